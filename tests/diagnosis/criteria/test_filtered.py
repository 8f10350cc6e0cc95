"""A late clock held against filters, on recordings of the independent generator."""

import numpy as np
import pytest

from imubench.diagnosis.config.criteria import ADMISSION
from imubench.diagnosis.config.shared import EVIDENCE
from imubench.diagnosis.criteria.conditional_aic import aic_gain
from imubench.diagnosis.criteria.delays import clear_readings, late_imu
from imubench.diagnosis.criteria.dynamic_score import screen
from imubench.diagnosis.criteria.equivalence import equivalents
from imubench.diagnosis.criteria.plausible_fit import holds_its_law
from imubench.diagnosis.criteria.trial import Gain, Kept
from imubench.diagnosis.noise.coherence import clear_of_noise
from imubench.diagnosis.noise.declared_noise import misfit
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.search.moves.dynamic_refits import refit_from_screening
from imubench.diagnosis.search.moves.swap_clock_for_filter import ClockToFilter, taken_again
from imubench.diagnosis.search.selected import Selection, candidates
from imubench.diagnosis.solve.refit import information, refit
from imubench.diagnosis.verdict.findings import findings
from imubench.effects import EFFECTS
from imubench.effects.bandwidth import QuickLowPass
from imubench.format1 import read
from imubench.proof.case import make_case
from tests.searching import moved

OFFSET = Hypothesis(EFFECTS["time_offset"], "imu2")
BOTH = ["gyro", "accel"]


def filtered(fit, kept, splines=True):
    """Return a fit and its effects once a clock's offset was held against filters."""
    state = moved(ClockToFilter(splines), fit, kept)
    return state.fit, list(state.kept)


def with_an_offset(folder, asked, seed, **options):
    """The fit of a generated hinge with a clock's offset in the model, where it is not from the start."""
    make_case(folder / "case", "hinge", effects=asked, seed=seed, seconds=12.0, **options)
    fit = nominal_fit(read(folder / "case")[0])
    if OFFSET not in fit.model.hypotheses:
        fit = refit(fit, (*fit.model.hypotheses, OFFSET))
    return with_noise(fit, 1)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("asked", "found"),
    [
        (("low_pass", "imu1", {"cutoff": 12.0, "channels": BOTH}), ("low_pass", "imu1")),
        (("low_pass", "imu2", {"cutoff": 12.0, "channels": BOTH}), ("low_pass", "imu2")),
        (("time_offset", "imu2", {"offset": 0.012}), ("time_offset", "imu2")),
    ],
)
def test_a_filter_takes_the_place_of_the_delay_that_it_was_taken_for(tmp_path, asked, found):
    fit = with_an_offset(tmp_path, [asked], 61)
    kept = [Kept(OFFSET, 100.0, Gain(0.0, 0.0, 0.0, np.zeros(1)), ())]
    after, (k,) = filtered(fit, kept)
    (h,) = after.model.hypotheses
    assert (h.effect.name, h.at) == found
    assert h == k.hypothesis
    if found[0] == "low_pass":
        assert np.exp(after.state.values[h.key("cutoff")][0]) == pytest.approx(asked[2]["cutoff"], rel=0.05)


@pytest.mark.slow
def test_a_filter_takes_the_place_of_a_delay_that_leaves_much_if_it_leaves_little(tmp_path):
    """On a free body the pose's clock takes the delay, and 2.5 times the noise is left."""
    asked = [("low_pass", "imu1", {"cutoff": 6.0, "channels": BOTH})]
    make_case(tmp_path / "case", "free", effects=asked, seed=5, seconds=15.0)
    fit = nominal_fit(read(tmp_path / "case")[0])
    (clock,) = fit.model.hypotheses
    assert misfit(fit) > ADMISSION.unexplained_misfit
    kept = [Kept.unjudged(clock)]
    after, (k,) = filtered(fit, kept)
    assert (k.hypothesis.effect.name, k.hypothesis.at) == ("low_pass", "imu1")
    assert np.exp(after.state.values[k.hypothesis.key("cutoff")][0]) == pytest.approx(6.0, rel=0.02)
    assert misfit(after) < 1.1


@pytest.mark.slow
@pytest.mark.parametrize(("cutoff", "found"), [(30.0, "low_pass[quick]@imu2"), (50.0, "time_offset@imu2")])
def test_a_filter_too_quick_to_be_told_from_a_delay_ties_with_it(tmp_path, cutoff, found):
    """What a filter does beside a delay is its curvature: of 30 Hz 12 nat, of 38 Hz 5.4."""
    fit = with_an_offset(tmp_path, [("low_pass", "imu2", {"cutoff": cutoff, "channels": BOTH})], 61)
    kept = [Kept(OFFSET, 100.0, Gain(100.0, 90.0, 110.0, np.zeros(1)), ())]
    after, kept = filtered(fit, kept)
    assert [h.name for h in after.model.hypotheses] == [found]
    (said,) = findings(Selection(after, tuple(kept), ()))
    equal = {(r.effect, r.at) for r in said.equivalent}
    assert (said.effect, said.at) == ("low_pass", "imu2") or ("low_pass", "imu2") in equal


@pytest.mark.slow
@pytest.mark.parametrize("gaps", [0, 1])
def test_a_filter_above_a_slow_motion_is_not_worse_than_its_delay(tmp_path, gaps):
    asked = ("low_pass", "imu1", {"cutoff": 43.0, "channels": BOTH})
    fit = with_an_offset(tmp_path, [asked], 63, gaps=gaps, vigour=0.5, band=7.0, gyro_noise=0.005, accel_noise=0.043)
    kept = [Kept(OFFSET, 100.0, Gain(0.0, 0.0, 0.0, np.zeros(1)), ())]
    after, (k,) = filtered(fit, kept)
    assert k.hypothesis.at == "imu1"
    said = {(k.hypothesis.effect.name, "imu1"), *((r.effect, r.at) for r in equivalents(after, k.hypothesis))}
    assert ("low_pass", "imu1") in said


@pytest.mark.slow
def test_a_filter_far_above_the_motion_is_equal_to_a_delay_at_the_imu_that_is_late(tmp_path):
    fit = with_an_offset(tmp_path, [("low_pass", "imu1", {"cutoff": 400.0, "channels": BOTH})], 62)
    imu, delay = late_imu(fit, OFFSET)
    assert imu.name == "imu1"
    assert delay == pytest.approx(1 / (2 * np.pi * 400.0), rel=0.1)
    assert ("low_pass", "imu1") in {(r.effect, r.at) for r in equivalents(fit, OFFSET)}


@pytest.mark.long
def test_a_quick_filter_is_found_before_anything_is_laid_over_what_its_delay_leaves(tmp_path):
    """It had been called a delay of 10 ms, beside a rocking mount at the other IMU."""
    told = {"seconds": 15.0, "gyro_noise": 0.00282, "accel_noise": 0.026, "colour": 0.1, "position_std": 0.00335}
    motion = {"band": 1.53, "vigour": 0.856, "rest": 0.312}
    asked = ("low_pass", "imu1", {"cutoff": 16.25, "channels": BOTH})
    make_case(tmp_path / "case", "hinge", effects=[asked], seed=2042633011, **told, **motion)
    fit = nominal_fit(read(tmp_path / "case")[0])
    (clock,) = fit.model.hypotheses
    after, (k,) = filtered(fit, [Kept.unjudged(clock)], splines=False)
    assert k.hypothesis.name == "low_pass[quick]@imu1"
    assert np.exp(after.state.values[k.hypothesis.key("cutoff")][0]) == pytest.approx(16.25, rel=0.02)
    assert aic_gain(fit, after) > 100
    assert misfit(after) < 1.1


@pytest.mark.long
def test_what_a_quick_filter_does_beside_delaying_is_taken_again_from_the_motion_it_leaves(tmp_path):
    fit = with_an_offset(tmp_path, [("low_pass", "imu2", {"cutoff": 9.4, "channels": BOTH})], 61, band=4.6)
    kept = [Kept(OFFSET, 100.0, Gain(0.0, 0.0, 0.0, np.zeros(1)), ())]
    right, (k,) = filtered(fit, kept, splines=False)
    effect = k.hypothesis.effect
    half = {part: 0.5 * c for part, c in effect.beside.items()}
    h = Hypothesis(QuickLowPass(effect.time, half, effect.slope, effect.delay), "imu2")
    wrong = refit(right, (h,), {h.key("cutoff"): right.state.values[h.key("cutoff")]})
    again, new = taken_again(wrong, h)
    assert wrong.cost > right.cost + 100.0  # nat: half of it is seen
    assert new.effect is not h.effect
    assert aic_gain(right, again) > -1.0  # as good as the one that was never wrong
    cutoff = np.exp(again.state.values[new.key("cutoff")][0])
    assert cutoff == pytest.approx(9.4, abs=3 * 9.4 * information(again)[1][new.key("cutoff")][0])


def test_what_is_loud_near_half_the_rate_is_no_motion():
    """A spline between its knots is; with it a filter's flattening would be computed from noise."""
    time = np.arange(1500) / 100.0
    slow = 3.0 * np.sin(2 * np.pi * 2.0 * time)[:, None] * np.ones(3)
    wild = 0.05 * np.cos(2 * np.pi * 49.0 * time)[:, None] * np.ones(3)
    white = 0.01 * np.random.default_rng(5).standard_normal((1500, 3))
    assert clear_of_noise(slow + white + wild, 0.01, 100.0) == pytest.approx(clear_of_noise(slow + white, 0.01, 100.0))
    assert clear_of_noise(slow + white + wild, 0.01, 100.0) < 6.0


def test_an_imu_that_stands_still_can_be_asked_for_its_delay(tmp_path):
    """On a base that is fixed a reading is one row for all times, and must be there at each of them."""
    make_case(tmp_path / "r", "hinge", [], seed=17, seconds=6.0, base="fixed")
    fit = nominal_fit(read(tmp_path / "r")[0])
    time, x = clear_readings(fit.model, fit.state, fit.model.recording.imus[0], fit.noise)
    assert x["gyro"].shape == x["accel"].shape == (len(time), 3)
    assert np.abs(x["gyro"]).max() < 1e-9
    assert np.linalg.norm(x["accel"], axis=1) == pytest.approx(np.full(len(time), 9.81), abs=0.01)


@pytest.mark.slow
def test_a_delay_of_one_triple_is_a_filter_however_quick(tmp_path):
    """0.2 ms of the accelerometer alone, 15 standard deviations: it was an unknown, for 100 samples a second."""
    quick = {"band": 4.58, "gyro_noise": 0.0014, "accel_noise": 0.0186, "position_std": 0.0026}
    asked = ("low_pass", "imu2", {"cutoff": 700.0, "channels": ["accel"]})
    make_case(tmp_path / "r", "hinge", [asked], 20261126, seconds=15.0, **quick)
    fit = nominal_fit(read(tmp_path / "r")[0])
    (h,) = [h for h in candidates(fit.model) if h.name == "low_pass[accel]@imu2"]
    trial = refit_from_screening(fit, screen(fit, [h]))
    assert trial.evidence > EVIDENCE.needed_nat
    assert holds_its_law(trial)
    assert np.exp(trial.fit.state.values[h.key("cutoff")]) == pytest.approx([700.0], rel=0.2)
