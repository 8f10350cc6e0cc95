"""Held-out prediction by one linear step, against fitting each half."""

from dataclasses import replace

import numpy as np
import pytest

from imubench.diagnosis.criteria.cross_validation import block_of, gain, held_out, log_score_gain, predicted
from imubench.diagnosis.criteria.score_test import score
from imubench.diagnosis.criteria.trial import Gain
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.search.selected import candidates
from imubench.diagnosis.solve.levenberg_marquardt import solve
from imubench.diagnosis.solve.refit import refit
from imubench.format1 import read
from imubench.proof.case import make_case


def exact(fit):
    """Return the cost of every block, its parameters fitted to the other half in full."""
    start = min(r.time.min() for r in fit.measured)
    end = max(r.time.max() for r in fit.measured)
    cost = np.zeros(int(block_of(np.array([end]), start, end)[0]) + 1)

    def on(half):
        stamps = {n: np.clip(t - fit.model.start, start, end) for n, t in fit.model.stamps.items()}
        return replace(fit.model, masks={n: block_of(t, start, end) % 2 == half for n, t in stamps.items()})

    for half in (0, 1):
        learnt = solve(on(half), fit.state, fit.noise, fit.anchor, steps=3)
        model = replace(on(1 - half), fixed=learnt.state.values)
        judged = solve(model, replace(fit.state, values=learnt.state.values), fit.noise, fit.anchor, steps=3)
        for rows in judged.measured:
            block = block_of(rows.time, start, end)
            own = block % 2 == 1 - half
            cost += np.bincount(block[own], 0.5 * np.sum(rows.whitened**2, axis=1)[own], len(cost))
    return cost


@pytest.mark.slow
def test_one_linear_step_predicts_as_fitting_each_half_does(tmp_path):
    make_case(tmp_path / "r", "hinge", [("accel_scale", "imu1")], 5, seconds=12.0)
    fit = nominal_fit(read(tmp_path / "r")[0])
    best = score(fit, [h for h in candidates(fit.model) if h.effect.name == "accel_scale"])[0].hypothesis
    better = refit(fit, (*fit.model.hypotheses, best))
    won = gain(held_out(fit), held_out(better), np.random.default_rng(0))
    full = float(np.sum(exact(fit) - exact(better)))
    assert best.at == "imu1"
    assert won.low > 0
    assert won.value == pytest.approx(full, rel=0.1)  # linear but for the product of scale and attitude


@pytest.mark.parametrize(
    ("blocks", "surely"),
    [
        ([3226.0, -0.15, -0.1, -0.05, 0.0, -0.1, -0.15, -0.1], True),  # friction, until the swing has ended
        ([8.0, -2.0, -1.0, 0.5, -2.0, -1.0, 0.0, -1.5], False),
        ([300.0, -80.0, -90.0, 20.0, -100.0, -70.0, -20.0, -60.0], False),
        ([3.0, 2.0, 4.0, 3.0, 2.0, 3.0, 4.0, 2.0], True),
        ([11.6, 1.5, -1.2, 0.4, -0.7, -0.6, 0.2, 2.3], True),  # a clock's skew, most of it at the end
        ([6.0, 1.5, -1.2, 0.4, -0.7, -0.6, 0.2, 2.3], False),
    ],
)
def test_what_acts_in_one_block_foretells_and_what_harms_the_others_does_not(blocks, surely):
    won = gain(np.array(blocks), np.zeros(len(blocks)), np.random.default_rng(1))
    assert won.is_sure() == surely


def test_a_gain_that_is_asked_for_is_asked_of_its_lower_end():
    won = Gain(100.0, 40.0, 160.0, np.zeros(8))
    assert won.is_sure(30.0) and not won.is_sure(50.0)


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    folder = tmp_path_factory.mktemp("score") / "r"
    make_case(folder, "hinge", [], 2, seconds=5.0, rate=50.0)
    return nominal_fit(read(folder)[0])


def test_at_one_noise_the_log_score_is_what_is_predicted(plain):
    turned = {"imu1.rotation": plain.state.values["imu1.rotation"] + 0.05}  # rad: a mount held where it is not
    model = replace(plain.model, fixed=turned)
    other = solve(model, replace(plain.state, values=plain.state.values | turned), plain.noise, plain.anchor)
    ways = [asked(plain, other, np.random.default_rng(0)) for asked in (log_score_gain, predicted)]
    assert ways[0].value == pytest.approx(ways[1].value, rel=1e-9)
    assert ways[0].value < -1.0  # nat


def test_a_noise_that_is_too_loud_costs_its_logarithm(plain):
    noise = plain.noise | {"imu1.gyro": 2 * plain.noise["imu1.gyro"]}
    loud = solve(plain.model, plain.state, noise, plain.anchor)
    (rows,) = (r for r in plain.measured if r.name == "imu1.gyro")
    won = log_score_gain(plain, loud, np.random.default_rng(0))
    told = predicted(plain, loud, np.random.default_rng(0))
    assert won.value == pytest.approx(told.value - rows.residual.value.size * np.log(2), rel=1e-9)
    assert won.high < 0
