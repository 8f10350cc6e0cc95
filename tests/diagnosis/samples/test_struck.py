"""Knocks that a quick hand hides among its own peaks: what no motion explains tells them apart."""

import numpy as np
import pytest

from imubench.diagnosis.config.samples import HIGH_BAND
from imubench.diagnosis.config.shared import EVIDENCE
from imubench.diagnosis.criteria.impact_test import elsewhere
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.result import Finding, Interval
from imubench.diagnosis.samples.check_findings import joined
from imubench.diagnosis.samples.faint_impacts import faint_knocks
from imubench.diagnosis.samples.high_band import high, high_pass
from imubench.diagnosis.samples.screening import check_samples
from imubench.diagnosis.search.confidence import DOUBTFUL
from imubench.diagnosis.solve.gauss_newton import extended
from imubench.diagnosis.verdict import impacts
from imubench.diagnosis.verdict.impacts import unseen_knocks
from imubench.effects import EFFECTS
from imubench.format1 import read
from imubench.proof.case import make_case
from imubench.recording import Imu

QUICK = {"band": 6.995, "vigour": 0.783, "rest": 0.178, "rate": 128.0, "gyro_noise": 0.00161, "accel_noise": 0.01044}
TIMES = [2.1, 4.6, 6.1, 8.4, 10.8, 12.7]


def quick_limb(folder, effects, seed=1198967575):
    """A limb in a quick hand: the fit, what the raw samples say, and the peaks that they leave out."""
    make_case(folder / "r", "pendulum", effects, seed, seconds=15.0, colour=0.174, rotation_std=0.019, **QUICK)
    recording = read(folder / "r")[0]
    samples = check_samples(recording)
    return nominal_fit(samples.heard(recording), samples.masks), samples


def test_knocks_that_the_raw_samples_doubt_are_found_beside_the_fit(tmp_path):
    fit, samples = quick_limb(tmp_path, [("impacts", "imu1", {"times": TIMES, "peak": 0.3})])
    assert not samples.findings
    (found,) = unseen_knocks(fit, samples.struck, ())
    assert (found.effect, found.at) == ("impacts", "imu1")
    times = found.parameters["times"].value
    assert len(times) >= 2
    assert all(np.min(np.abs(np.array(TIMES) - t)) < 0.06 for t in times)


@pytest.mark.parametrize("seed", [1198967575, 3, 4, 5])
def test_a_quick_hand_s_own_peaks_are_none(tmp_path, seed):
    fit, samples = quick_limb(tmp_path, [], seed)
    assert unseen_knocks(fit, samples.struck, ()) == ()


def test_a_stop_knocks_as_well(tmp_path):
    class Stop:
        effect, at = "end_stop", "joint"

    fit, samples = quick_limb(tmp_path, [("impacts", "imu1", {"times": TIMES, "peak": 0.3})])
    assert unseen_knocks(fit, samples.struck, (Stop(),)) == ()


def test_the_peak_of_a_slip_is_the_slip_s(tmp_path):
    """It begins before the slip is dated, and a peak of its own there would be a knock."""
    fit, samples = quick_limb(tmp_path, [("impacts", "imu1", {"times": TIMES, "peak": 0.3})])
    (before,) = unseen_knocks(fit, samples.struck, ())
    first, *others = before.parameters["times"].value
    slip = Hypothesis(EFFECTS["mount_shift"].starting(time=first + 0.1 - fit.model.start), "imu1")
    (after,) = unseen_knocks(extended(fit, (*fit.model.hypotheses, slip)), samples.struck, ())
    assert list(after.parameters["times"].value) == others


FAINT = {"band": 3.0, "rate": 100.0, "gyro_noise": 0.002, "accel_noise": 0.02}


def calm(folder, effects, rig="hinge", seed=77, **options):
    """A rig in a calm hand: the fit, what the raw samples say, and the peaks that they leave out."""
    make_case(folder / "r", rig, effects, seed, seconds=15.0, **(FAINT | options))
    recording = read(folder / "r")[0]
    samples = check_samples(recording)
    return nominal_fit(samples.heard(recording), samples.masks), samples


@pytest.mark.long
def test_several_knocks_too_faint_for_the_raw_samples_are_found_together(tmp_path):
    fit, samples = calm(tmp_path, [("impacts", "imu1", {"times": TIMES, "peak": 0.2})])
    assert not [f for f in samples.findings if f.effect == "impacts"]
    (found,) = unseen_knocks(fit, samples.struck, ())
    assert (found.effect, found.at) == ("impacts", "imu1")
    times = found.parameters["times"].value
    assert len(times) >= 3
    assert all(np.min(np.abs(np.array(TIMES) - t)) < 0.06 for t in times)
    (doubted,) = unseen_knocks(fit, samples.struck, (), {"imu1"})
    assert doubted.confidence <= DOUBTFUL < found.confidence  # springs that foretold nothing may ring so
    lost = Finding("dropouts", "imu1", 0.99, {}, Interval(0.0, (0.0, 0.0)))
    assert unseen_knocks(fit, samples.struck, (lost,)) == ()


@pytest.mark.long
def test_a_calm_hand_has_no_faint_knocks(tmp_path):
    fit, samples = calm(tmp_path, [])
    assert unseen_knocks(fit, samples.struck, ()) == ()


@pytest.mark.long
def test_knocks_that_a_free_motion_follows_are_rougher_than_it_is_elsewhere(tmp_path):
    fit, samples = calm(tmp_path, [("impacts", "imu1", {"times": TIMES, "peak": 0.2})], "free", rate=200.0)
    assert not [f for f in samples.findings if f.effect == "impacts"]
    (found,) = unseen_knocks(fit, samples.struck, ())
    times = found.parameters["times"].value
    assert len(times) >= 3
    assert all(np.min(np.abs(np.array(TIMES) - t)) < 0.06 for t in times)


@pytest.mark.parametrize("band", [pytest.param(3.0, marks=pytest.mark.long), 10.0])
def test_the_quickest_strokes_of_a_free_body_are_no_knocks(tmp_path, monkeypatch, band):
    fit, samples = calm(tmp_path, [], "free", 80, band=band, vigour=1.4, rest=0.3, rate=128.0)
    (imu,) = fit.model.recording.imus
    power = high(imu.accel, high_pass(imu.rate))[64:-64]
    third = len(power) // 3
    quickest = imu.time[64:-64][np.argmax(power[: 3 * third].reshape(3, third), axis=1) + third * np.arange(3)]
    monkeypatch.setattr(impacts, "faint_knocks", lambda *_: tuple((t - 0.02, t + 0.05) for t in quickest))
    assert unseen_knocks(fit, samples.struck, ()) == ()


@pytest.mark.parametrize(("count", "found"), [(1, 0), (4, 4)])
def test_one_faint_peak_may_be_anything(count, found):
    rng = np.random.default_rng(5)
    time = np.arange(0, 20, 0.01)
    accel = 0.02 * rng.standard_normal((time.size, 3)) + np.array([0.0, 0.0, 9.81])
    for start in 4.0 * np.arange(count) + 3.0:
        accel[round(100 * start) + np.arange(3)] += 0.24 * np.sin(np.pi * np.arange(1, 4) / 4)[:, None]
    imu = Imu("imu1", time, np.zeros_like(accel), accel, 100.0)
    assert len(faint_knocks(imu, np.zeros(time.size, dtype=bool), 0.0)) == found


def test_peaks_near_one_another_are_one_and_single_samples_none():
    time = np.arange(0, 4, 0.01)
    assert joined(time[[50, 51, 52, 58, 59, 200]], HIGH_BAND.one_knock_s, EVIDENCE.events) == (
        (0.5, pytest.approx(0.59)),
    )
    assert joined(time[:0], HIGH_BAND.one_knock_s, EVIDENCE.events) == ()


def test_other_stretches_keep_away_from_peaks_and_from_one_another():
    time, counts = np.arange(0, 60, 0.01), np.ones(6000, dtype=bool)
    counts[3000:3010] = False
    others = elsewhere(time, counts, [(30.0, 30.1)])
    assert len(others) > 10
    starts = np.array([a for a, _ in others])
    assert np.diff(np.sort(starts)).min() > 0.5
    assert np.abs(starts - 30.0).min() > 0.3
