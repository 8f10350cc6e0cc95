"""Springs that stiffen, of the independent generator, and straight ones."""

import numpy as np
import pytest
from scipy.stats import chi2

from imubench.diagnosis.config.shared import EVIDENCE
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.problem.process_factors import state_rows
from imubench.diagnosis.search.moves.add_dynamic import state_trials
from imubench.diagnosis.search.nonlinear_spring import (
    LIKELY,
    NEEDED,
    bending,
    nonlinear_finding,
    promised,
    suspected_findings,
)
from imubench.diagnosis.solve.gauss_newton import extended
from imubench.effects import EFFECTS
from imubench.effects.soft_mounts import RockingMount, SoftMount
from imubench.format1 import read
from imubench.proof.case import make_case


def sprung(folder, asked, name, seed):
    """The fit of a hinge with a mount on straight springs in the model."""
    make_case(folder / "case", "hinge", effects=[asked], seed=seed, seconds=12.0, rate=100.0)
    h = Hypothesis(EFFECTS[name], "imu2")
    (best, *_) = state_trials(nominal_fit(read(folder / "case")[0]), [h], lambda _: None)
    return best.fit, h


@pytest.mark.slow
@pytest.mark.parametrize(
    ("asked", "name"),
    [
        (("hardening_mount", "imu2", {"frequency": 12.0, "damping_ratio": 0.15, "span": 1.2e-3}), "soft_mount"),
        (("soft_mount", "imu2"), "soft_mount"),
        (("rocking_mount", "imu2"), "rocking_mount"),
    ],
)
def test_springs_that_stiffen_are_told_from_straight_ones(tmp_path, asked, name):
    fit, h = sprung(tmp_path, asked, name, 21)
    fit = with_noise(fit, 4)
    assert (promised(fit, h, h.effect) > EVIDENCE.clear_nat) == (asked[0] == "hardening_mount")
    found = bending(fit, h, h.effect)
    if asked[0] == "hardening_mount":
        assert found.evidence > NEEDED
        assert found.heldout.value > 0
        said = nonlinear_finding(found)
        assert (said.effect, said.at) == ("unknown", "imu2")
        assert (said.parameters["stiffening"].value > 3 * said.parameters["stiffening"].std).any()
        assert sum(said.where.channels.values()) == pytest.approx(1.0, abs=0.2)
    else:
        assert found.evidence < 0.5 * NEEDED


@pytest.mark.parametrize("straight", [SoftMount(), RockingMount(), SoftMount(axes=1)])
def test_a_bent_spring_s_rows_are_those_of_a_straight_one_where_it_does_not_bend(tmp_path, straight):
    make_case(tmp_path / "case", "hinge", effects=[], seed=4, seconds=6.0, rate=50.0)
    fit = nominal_fit(read(tmp_path / "case")[0])
    size = np.array([2e-3, 1e-3, 3e-3])
    rows = []
    for effect in (straight, straight.bending(size)):
        begun = extended(fit, (Hypothesis(effect, "imu2"),))
        moved = begun.state.coefficients + 1e-3 * np.random.default_rng(2).normal(size=begun.state.coefficients.shape)
        rows.append((begun, type(begun.state)(moved, begun.state.values)))
    (one, two) = (next(iter(state_rows(begun.model, state))).residual for begun, state in rows)
    np.testing.assert_allclose(two.value, one.value, atol=1e-12)
    begun, state = rows[1]
    key = next(name for name in state.values if name.endswith(".bend"))
    slope = next(jac for (name, _), jac in two.blocks.items() if name == key)
    for axis in range(3):
        values = state.values | {key: 1e-6 * np.eye(3)[axis]}
        bent = next(iter(state_rows(begun.model, type(state)(state.coefficients, values)))).residual.value
        np.testing.assert_allclose(
            (bent - two.value) / 1e-6, slope[..., axis], rtol=1e-5, atol=1e-6 * np.abs(slope).max()
        )


def test_soft_mounts_that_straight_springs_would_hardly_promise_are_said_and_not_surely(tmp_path):
    assert chi2(3).sf(2 * LIKELY) < 0.002 < chi2(3).sf(2 * EVIDENCE.needed_nat) < 0.02
    make_case(tmp_path / "r", "hinge", [], 3, seconds=4.0, rate=40.0)
    soft, rocks = Hypothesis(EFFECTS["soft_mount"], "imu1"), Hypothesis(EFFECTS["rocking_mount"], "imu2")
    nominal = nominal_fit(read(tmp_path / "r")[0])
    fit = extended(nominal, (soft, rocks), {})
    (said,) = suspected_findings({soft: 1.01 * LIKELY, rocks: 380.0}, fit)
    assert (said.effect, said.at, said.confidence) == ("unknown", "imu1", 0.6)
    assert "not straight" in said.where.depends_on
    assert suspected_findings({soft: 0.99 * LIKELY}, fit) == []
    assert suspected_findings({soft: 50.0}, nominal) == []  # a term has taken its place
