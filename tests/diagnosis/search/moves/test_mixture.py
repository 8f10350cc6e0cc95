"""Friction in its right mixture: of every mixture of laws the one that made the swing, wherever the search begins."""

import numpy as np
import pytest

from imubench.diagnosis.criteria.trial import Kept
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.pipeline import diagnose
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.search.moves.merge import Merge
from imubench.diagnosis.search.moves.swap_friction import FrictionMixture, together
from imubench.diagnosis.solve.refit import evidence_over, refit
from imubench.effects import EFFECTS
from tests.searching import moved

VISCOUS, DRY, DRAG = "viscous_friction", "dry_friction", "air_drag"
SIZES = {VISCOUS: 5e-4, DRY: 2.8e-3, DRAG: 7e-5}  # N m s, N m, N m s^2: each takes about as much from a swing
MIXTURES = [(VISCOUS,), (DRY,), (DRAG,), (VISCOUS, DRY), (VISCOUS, DRAG), (DRY, DRAG)]


def fitted_with(recording, names):
    held = tuple(Hypothesis(EFFECTS[name], "joint") for name in names)
    fit = with_noise(refit(nominal_fit(recording), held))
    return fit, [Kept(h, 100.0, None, ()) for h in held]


def names_of(fit):
    return {h.effect.name for h in fit.model.hypotheses}


@pytest.mark.parametrize("there", MIXTURES)
@pytest.mark.parametrize(
    "begun", [(VISCOUS,), *(pytest.param(some, marks=pytest.mark.slow) for some in ((VISCOUS, DRY), (DRY, DRAG)))]
)
def test_the_mixture_that_is_there_is_found_from_any_other(swung, there, begun):
    recording = swung({name: SIZES[name] for name in there})
    state = moved(FrictionMixture(), *fitted_with(recording, begun))
    assert names_of(state.fit) == set(there) == {k.hypothesis.effect.name for k in state.kept}
    for name in there:
        (found,) = state.fit.state.values[f"{name}@joint.{EFFECTS[name].parameters[0].name}"]
        assert abs(found / SIZES[name] - 1) < 0.05  # 2 % at most in these; one law for another is 30 % off and more


def test_one_law_stands_in_for_two_others_and_neither_alone_replaces_it(swung):
    """Why the search, which adds one law after the other, needs this."""
    recording = swung({DRY: SIZES[DRY], DRAG: SIZES[DRAG]})
    viscous, dry, drag, both = (
        fitted_with(recording, names)[0] for names in ((VISCOUS,), (DRY,), (DRAG,), (DRY, DRAG))
    )
    assert max(evidence_over(viscous, dry), evidence_over(viscous, drag)) < 0.0 < evidence_over(viscous, both)


def test_two_laws_are_not_merged_into_the_third(swung):
    recording = swung({DRY: SIZES[DRY], DRAG: SIZES[DRAG]}, noise=2e-3)
    fit, kept = fitted_with(recording, (DRY, DRAG))
    assert names_of(moved(Merge(), fit, kept).fit) == {DRY, DRAG}


def test_laws_have_what_all_of_them_gain(swung):
    fit, kept = fitted_with(swung({DRY: SIZES[DRY], DRAG: SIZES[DRAG]}), (DRY, DRAG))
    first, second = together(fit, kept)
    assert first.heldout == second.heldout
    alone = fitted_with(swung({DRY: SIZES[DRY]}), (DRY,))
    assert together(*alone) == alone[1]
    assert first.heldout.is_sure(100.0)


def test_without_friction_nothing_is_weighed(swung):
    fit, kept = fitted_with(swung({}, seconds=3.0), ())
    state = moved(FrictionMixture(), fit, kept)
    assert state.fit is fit and not state.use.decisions


@pytest.mark.slow
@pytest.mark.parametrize("there", MIXTURES)
def test_a_diagnosis_names_the_mixture_and_nothing_else(swung, there):
    found, _ = diagnose(swung({name: SIZES[name] for name in there}, off=lambda q: 3e-3 + 1e-3 * np.sin(q)))
    assert {f.effect for f in found.findings} == set(there)
    assert all(f.confidence > 0.9 for f in found.findings) and found.verdict == "explained"
