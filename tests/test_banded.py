"""The axes below a band that the data choose: the carried constraint, the choice, the region, and real IMUs on foam."""

import json
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.banded import CHI_SQUARE, Run, case
from benchmarks.hinge_rigs import random_rig
from benchmarks.real_axes import ROUNDED, ROWS, trial
from imubench.errors import InputError
from imubench.estimators import ESTIMATORS, banded, olsson2020, sliding
from imubench.estimators.band_fits import Noise, _carry, _gradients, band_fit, ladder
from imubench.estimators.carried import below, filtered, runs_below, shared
from imubench.estimators.olsson2020 import deviation
from imubench.estimators.spherical import coordinates
from imubench.paired import Paired
from imubench.rotations import multiply
from imubench.run import estimate
from imubench.score import axis_deviation
from tests.command import here

NOISE = 0.0044, 0.015  # rad/s, m/s^2 a sample: an MTw at 50 Hz
RATE = 50.0  # Hz


def samples_of(rig):
    return Paired(rig.time, rig.gyro[0], rig.accel[0], rig.gyro[1], rig.accel[1])


def clean_rig(seed=0, count=2000, amplitude=0.6):
    return random_rig(np.random.default_rng(seed), count, RATE, lever=0.0, amplitude=amplitude)


def frames_about(axes):
    """Right-handed frames (2, 3, 3) whose first rows are the axes, their other rows turned at random."""
    rng, frames = np.random.default_rng(7), []
    for axis in axes:
        across = rng.normal(size=3)
        across -= across @ axis * axis
        across /= np.linalg.norm(across)
        frames.append(np.stack([axis, across, np.cross(axis, across)]))
    return np.stack(frames)


def lengths_across(rates):
    return np.linalg.norm(rates[..., 1:], axis=-1)


# --- the carried constraint ---


@pytest.mark.parametrize("hz", [0.7, 1.5, 4.0])
def test_a_rigid_hinge_obeys_the_carried_constraint_below_any_band(hz):
    """And not the one of rates that are filtered in their own axes, unless the band holds all of the motion."""
    rig = clean_rig()
    pieces = runs_below(samples_of(rig), hz)
    frames = frames_about(rig.axes)
    one, two = lengths_across(below(pieces, frames).rates)
    size = np.sqrt(np.mean(one**2))
    # trapezoids of the hinge's rate at 50 Hz: 1e-3 of a radian
    assert np.sqrt(np.mean((one - two) ** 2)) < 2e-3 * size
    own = filtered(pieces)
    apart = np.linalg.norm(np.cross(own.gyro1, rig.axes[0]), axis=1) - np.linalg.norm(
        np.cross(own.gyro2, rig.axes[1]), axis=1
    )
    if hz < 1.0:  # the hinge turns at 0.1 to 1 Hz
        assert np.sqrt(np.mean(apart**2)) > 0.05 * size


def test_what_an_accelerometer_reads_along_the_axis_is_linear_and_stays_equal():
    rig = clean_rig(1)
    found = below(runs_below(samples_of(rig), 0.7), frames_about(rig.axes))
    np.testing.assert_allclose(found.forces[0, :, 0], found.forces[1, :, 0], atol=1e-9)  # rounding


def test_without_a_filter_it_is_the_constraint_of_the_paper():
    rig = clean_rig(2).noisy(np.random.default_rng(2), *NOISE)
    found = band_fit(samples_of(rig), None, Noise((NOISE[0], NOISE[0]), True))
    plain = olsson2020.estimate(rig.recording())
    assert deviation(found.axes, plain.value) < 1e-7  # rad, where the carrying ends
    assert found.solution.cost == pytest.approx(plain.details["cost"])


def test_a_step_of_an_axis_moves_the_carried_rates_as_is_said():
    """Finite differences at a fixed hinge angle: d|across| = slope . step, with the length along the axis as slope."""
    rig = clean_rig(3)
    samples, frames, hz = samples_of(rig), frames_about(rig.axes), 1.0
    pieces = runs_below(samples, hz)
    found, step = below(pieces, frames), 1e-6
    low = pieces.low_pass
    speed = samples.gyro2 @ frames[1, 0] - samples.gyro1 @ frames[0, 0]
    angle = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1])) / RATE])
    back = np.exp(1j * angle)
    every = slice(None, None, int(RATE / (6 * hz)))
    for k in (1, 2):
        moved = [
            frames[1, k] + sign * (-step) * frames[1, 0] for sign in (1, -1)
        ]  # direction k as the axis turns to it
        other = frames[1, 3 - k]
        lengths = []
        for direction in moved:
            across = samples.gyro2 @ direction + 1j * (samples.gyro2 @ other)
            across = across if k == 1 else 1j * across.conj()
            lengths.append(np.abs(low.apply(across * back)[every]))
        numerical = (lengths[0] - lengths[1]) / (2 * step)
        along, parts = found.rates[1, :, 0], found.rates[1, :, 1:]
        slope = -along * parts[:, k - 1] / np.linalg.norm(parts, axis=1)
        np.testing.assert_allclose(numerical, slope, atol=1e-5 * np.abs(slope).max())  # central differences


def test_gradients_of_the_samples_add_up_to_that_of_the_cost():
    rig = clean_rig(4).noisy(np.random.default_rng(4), 0.05, 0.2)
    found = _carry(runs_below(samples_of(rig), 2.0), coordinates(rig.axes))
    total = _gradients(found.below, found.solution).sum(axis=0)
    each = np.abs(_gradients(found.below, found.solution)).sum(axis=0)
    assert (np.abs(total) < 1e-5 * each).all()  # at a minimum it vanishes, as far as descents go
    turned = replace(found.solution, frames=found.solution.frames + 1e-3)
    assert (np.abs(_gradients(found.below, turned).sum(axis=0)) > 1e-4 * each).any()  # and not beside one


def test_shared_motion_tells_the_pairing_of_the_signs():
    rig = clean_rig(5)
    pieces = runs_below(samples_of(rig), None)
    right = shared(pieces, frames_about(rig.axes)).coherence
    wrong = shared(pieces, frames_about(rig.axes * [[1.0], [-1.0]])).coherence
    assert right > 0.999 > 0.8 > wrong


# --- the choice and the region ---


def test_bands_of_half_an_octave_down_to_twenty_periods():
    bands = ladder(samples_of(clean_rig(count=2000)))
    assert bands[0] is None
    assert bands[1] == pytest.approx(RATE / 3)
    np.testing.assert_allclose(np.divide(bands[2:], bands[1:-1]), 0.5**0.5)
    assert bands[-1] * 40.0 > 20.0 > bands[-1] * 0.5**0.5 * 40.0  # 40 s


@pytest.mark.parametrize("seed", [0, *(pytest.param(n, marks=pytest.mark.long) for n in range(1, 6))])
def test_rigid_rigs_lose_nothing(seed):
    """Against all samples: not farther off by more than what the narrower band is unsure of, and inside its region."""
    clean = random_rig(np.random.default_rng([1, seed]), 2000, RATE, lever=0.0, planar=bool(seed % 2))
    recording = clean.noisy(np.random.default_rng([2, seed]), *NOISE).recording()
    recording = replace(recording, imus=tuple(replace(i, gyro_noise_std=NOISE[0]) for i in recording.imus))
    answer, plain = banded.estimate(recording), olsson2020.estimate(recording)
    assert answer.status == "converged"
    off, before = axis_deviation(answer.value, clean.axes), axis_deviation(plain.value, clean.axes)
    sure = np.array([answer.details["uncertainty_1"], answer.details["uncertainty_2"]])
    assert (off < before + sure).all()
    assert (off < 2 * sure).all()
    assert sure.max() < np.deg2rad(1.0)  # noise alone: hundredths, in planar motion tenths


@pytest.mark.long
def test_regions_hold_the_truth_as_often_as_they_say():
    """Chi-square of four degrees over 20 rigs whose noise is declared; `benchmarks.banded` has soft ones."""
    squares = []
    for seed in range(20):
        clean = random_rig(np.random.default_rng([3, seed]), 1000, RATE, lever=0.0, amplitude=0.5)
        recording = clean.noisy(np.random.default_rng([4, seed]), *NOISE).recording()
        recording = replace(recording, imus=tuple(replace(i, gyro_noise_std=NOISE[0]) for i in recording.imus))
        answer = banded.estimate(recording)
        off = (answer.value - clean.axes).ravel()
        squares.append(off @ np.linalg.pinv(answer.covariance, rcond=1e-9, hermitian=True) @ off)
    inside = np.mean(np.array(squares) < CHI_SQUARE)
    assert inside >= 0.85  # 20 runs of 95 %: under 17 of them once in 60 times
    assert np.mean(squares) / 4 > 0.2  # and not by regions that are five times too wide


@pytest.mark.parametrize("seed", [1001, 1006, 1026])
def test_imus_that_rock_are_right_below_the_band_and_inside_the_region(seed):
    one = case(seed)
    run = Run(one, banded.estimate(one.recording), olsson2020.estimate(one.recording))
    ours, plain = run.errors
    assert one.kind == "rocking"
    assert run.banded.status == "converged"
    assert run.inside
    assert ours < max(plain, 0.5)  # deg
    assert 0.0 < run.banded.details["band"] < 5.0  # Hz: a hand of at most 2 Hz on mounts of 5 Hz and more


def test_fast_hands_do_not_turn_the_pairing_round():
    """Lever arms in fast motion have the accelerometers pair the signs wrongly; the hinge's angle tells them right."""
    one = case(1000)
    undeclared = replace(one.recording, imus=tuple(replace(i, mount_rotation_std=None) for i in one.recording.imus))
    one = replace(one, recording=undeclared)
    run = Run(one, banded.estimate(undeclared), olsson2020.estimate(undeclared))
    ours, plain = run.errors
    assert ours < 1.0 and plain > 90.0  # deg
    assert run.banded.pairing == "from data"
    assert run.inside


def test_mounts_declared_the_wrong_way_round_do_not_turn_it_either():
    one = case(1000)
    imu1, imu2 = (replace(i, mount_rotation_std=0.05) for i in one.recording.imus)
    about_x = np.array([0.0, 1.0, 0.0, 0.0])  # by half a turn: +y of the segment becomes -y
    imu2 = replace(imu2, mount_quaternion=multiply(about_x, imu2.mount_quaternion))
    answer = banded.estimate(replace(one.recording, imus=(imu1, imu2)))
    assert answer.pairing == "from data"
    assert np.rad2deg(deviation(answer.value, one.axes)) < 1.0


def test_a_wider_search_says_which_band_and_why():
    one = case(2)
    answer = banded.estimate(one.recording)
    said = banded.explained(answer)
    assert said.startswith(f"below {answer.details['band']:.3g} Hz, the surest of those that keep the motion")
    assert "neighbouring bands agree" in said
    assert "mu + 2 sigma" in said
    assert all(np.isfinite(v) for v in answer.details.values())
    assert banded.explained(olsson2020.estimate(one.recording)) == ""
    assert "both IMUs filtered below 3 Hz" in banded.explained(estimate("olsson2020", one.recording, band=3.0))


def test_gaps_and_uneven_stamps_do_little():
    clean = clean_rig(6, count=3000)
    rig = clean.noisy(np.random.default_rng(6), *NOISE)
    rng = np.random.default_rng(7)
    keep = np.setdiff1d(np.arange(3000), [*range(1000, 1100), *range(2000, 2030), *rng.integers(0, 3000, size=20)])
    imus = tuple(
        replace(i, time=i.time[keep] + rng.uniform(0, 0.002, size=keep.size), gyro=i.gyro[keep], accel=i.accel[keep])
        for i in rig.recording().imus
    )
    second = replace(imus[1], time=imus[0].time)
    answer = banded.estimate(replace(rig.recording(), imus=(imus[0], second)))
    assert answer.status == "converged"
    # stamps wrong by up to 2 ms of rates that change by some rad/s^2: hundredths of a rad/s
    assert np.degrees(deviation(answer.value, clean.axes)) < 0.3


def test_pieces_that_are_too_short_say_so():
    rig = clean_rig(count=400)
    with pytest.raises(InputError, match=r"expected .* s of both IMUs without a gap, got at most 7\.98 s"):
        runs_below(samples_of(rig), 0.3)


def test_band_of_a_band():
    """Filtered below a band first, the estimator finds its own below that, and its covariance is not scaled again."""
    one = case(2)
    answer = estimate(banded.NAME, one.recording, band=5.0)
    assert answer.details["band"] < 5.0
    assert answer.details["independent_samples"] == 1.0
    assert answer.details["filtered_below"] == 5.0


def _first(imu, count):
    return replace(imu, time=imu.time[:count], gyro=imu.gyro[:count], accel=imu.accel[:count])


@pytest.mark.parametrize("name", [e.name for e in ESTIMATORS.values()])
def test_every_estimator_takes_a_band(name):
    two = ESTIMATORS[name].imus == 2
    recording = clean_rig(8, count=1500).noisy(np.random.default_rng(8), *NOISE).recording()
    if not two:
        recording = replace(recording, rig="pendulum", imus=recording.imus[:1])
    if name == sliding.STREAM:  # slow: fitted again and again
        recording = replace(recording, imus=tuple(_first(imu, 400) for imu in recording.imus))
    answer = estimate(name, recording, band=6.0)
    assert answer.details["filtered_below"] == 6.0
    with pytest.raises(InputError, match="imu1: expected a band below 25 Hz"):
        estimate(name, recording, band=30.0)


# --- the command line ---


@pytest.mark.long
def test_band_on_the_command_line(tmp_path):
    done = here("run", "hinge-soft", "--band", 3, "--out", "run", folder=tmp_path)
    assert done.code == 0, done.err
    assert "both IMUs filtered below 3 Hz" in " ".join(done.out.split())
    score = json.loads((tmp_path / "run" / "score.json").read_text())
    assert score["estimate"]["details"]["filtered_below"] == 3.0
    done = here("estimate", "olsson2020-banded", "run/recording", "--out", "est", folder=tmp_path)
    assert done.code == 0, done.err
    written = json.loads((tmp_path / "est" / "estimate.json").read_text())
    assert "the surest of those that keep the motion" in written["band"]
    assert "the surest of those that keep the motion" in " ".join(done.out.split())
    done = here("estimate", "seel2012", "run/recording", "--band", 30, folder=tmp_path)
    assert done.code == 2
    assert "imu1: expected a band below 25 Hz" in " ".join(done.err.split())
    assert not (tmp_path / "runs").exists()


# --- real recordings ---


@pytest.fixture(scope="module")
def foam(recordings):
    return {joint: trial(recordings / "diodem" / "trial1", joint, "nonrigid") for joint in ROWS}


@pytest.mark.parametrize("joint", ROWS)
def test_real_imus_on_foam_below_3_hz(foam, joint):
    """The table that a practitioner would make: axes carried from the IMUs screwed on, as they are declared."""
    recording, axes = foam[joint]
    answer = estimate("olsson2020", recording, band=3.0)
    assert answer.status == "converged"
    off = np.degrees(axis_deviation(answer.value, axes["declared"]))
    assert off == pytest.approx(ROWS[joint], abs=0.15)  # deg; filters and the slow band of the reference differ by 0.1


@pytest.mark.parametrize("joint", ROWS)
def test_real_imus_on_foam_below_their_own_band(foam, joint):
    recording, axes = foam[joint]
    answer = banded.estimate(recording)
    assert answer.status == "converged"
    off = axis_deviation(answer.value, axes["declared"])
    assert (np.degrees(off) <= np.array(ROWS[joint]) + ROUNDED / 2).all()
    # beside the optical reference, which is good to half a degree itself
    sure = np.array([answer.details["uncertainty_1"], answer.details["uncertainty_2"]])
    assert (axis_deviation(answer.value, axes["optical"]) < sure + np.deg2rad(0.5)).all()


@pytest.mark.parametrize("joint", ["3-4", pytest.param("4-5", marks=pytest.mark.long)])
def test_real_imus_screwed_on_lose_nothing(recordings, joint):
    recording, axes = trial(recordings / "diodem" / "trial1", joint, "rigid")
    answer, plain = banded.estimate(recording), olsson2020.estimate(recording)
    off, before = (np.degrees(axis_deviation(e.value, axes["optical"])) for e in (answer, plain))
    assert (off < before + 0.3).all()  # deg; the reference itself is good to half a degree
