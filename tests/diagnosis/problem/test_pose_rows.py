"""Poses whose errors wander: told from those that do not, and weighed by what is white in them."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

from imubench import rotations
from imubench.diagnosis.candidates.begin import begin
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.pipeline import diagnose
from imubench.diagnosis.problem.hypothesis import State
from imubench.diagnosis.problem.pose_factors import Lasting, pose_errors, slopes
from imubench.diagnosis.residual_checks.fit_summary import beside_motion
from imubench.diagnosis.samples.pose_correlation import GaussMarkov, correlated_poses
from imubench.diagnosis.solve.gauss_newton import all_rows
from imubench.diagnosis.solve.refit import information
from imubench.diagnosis.solve.subset import cut
from imubench.jets import Jet, Turn
from imubench.links import Motion
from imubench.recording import Imu, Pose, Recording

RATE, SECONDS = 200.0, 20.0
FORGETS, SIZE = 10.0, 2e-3  # per s, rad
BIAS = np.array([0.008, -0.004, -0.005])  # rad/s


def wandering(count, size, rate=RATE, seed=0, forgets=FORGETS):
    """Errors (n, 3) of first order, smoothed over three samples as an optical record's maker would."""
    keep = np.exp(-forgets / rate)
    draws = np.random.default_rng(seed).standard_normal((count + 400, 3)) * size * np.sqrt(1 - keep**2)
    return np.apply_along_axis(np.convolve, 0, lfilter([1], [1, -keep], draws, axis=0)[400:], np.ones(3) / 3, "same")


def turned(time):
    """Attitudes as Euler angles that are sums of sines, up to 3 Hz."""
    angles = [[0.5, 0.9, 0.1], [0.3, 2.1, 1.0], [0.4, 3.0, 2.0]]
    return Rotation.from_euler("zyx", np.stack([a * np.sin(2 * np.pi * f * time + p) for a, f, p in angles], axis=1))


def moved(time):
    return np.stack([0.2 * np.sin(2 * np.pi * f * time) for f in (0.7, 1.1, 1.9)], axis=1)


def true_rate(time, h=1e-4):
    return (turned(time - h).inv() * turned(time + h)).as_rotvec() / (2 * h)


def quaternion(turn):
    return turn.as_quat(canonical=True)[:, [3, 0, 1, 2]]


def recorded(errors, bias=0.0):
    """A gyroscope beside a pose that is wrong by rotation vectors (n, 3) rad and a tenth of that in m."""
    time = np.arange(0, SECONDS, 1 / RATE)
    gyro = true_rate(time) + bias + 2e-3 * np.random.default_rng(3).standard_normal((time.size, 3))
    imu = Imu("imu1", time, gyro, np.zeros_like(gyro), RATE)
    q = quaternion(turned(time) * Rotation.from_rotvec(errors))
    return Recording("r", "free", (imu,), poses=(Pose("segment1", time, moved(time) + 0.1 * errors, q),))


def derivatives(time, h=1e-3):
    """The true position (n, 3) and its first three derivatives."""
    out = [moved(time + n * h) for n in (-2, -1, 0, 1, 2)]
    return (
        out[2],
        (out[3] - out[1]) / (2 * h),
        (out[3] - 2 * out[2] + out[1]) / h**2,
        (out[4] - 2 * out[3] + 2 * out[1] - out[0]) / (2 * h**3),
    )


def rate_slopes(time, h=1e-3):
    """How fast the true rate changes, and that in turn (n, 3)."""
    before, now, after = (true_rate(time + n * h) for n in (-1, 0, 1))
    return (after - before) / (2 * h), (after - 2 * now + before) / h**2


def errors_of(recording, wander, window=0.0):
    """Rows of the pose against the true motion, by part, where they count."""
    (pose,) = recording.poses
    q = quaternion(turned(pose.time))
    segment = Motion(
        Jet(true_rate(pose.time)), Jet(np.zeros((1, 3))), Jet(np.zeros((1, 3))), Turn(rotations.to_matrix(q)),
        Jet(moved(pose.time)),
    )  # fmt: skip
    smoothed = Lasting(wander, slopes(pose), Jet(np.full((1, 1), window)), rate_slopes(pose.time))
    each = derivatives(pose.time)
    rows = pose_errors(pose, segment, lambda order: Jet(each[order]), smoothed)
    return {part: error.value[np.isfinite(seen).all(axis=1)] for part, error, seen in rows}


def test_rows_of_the_true_motion_are_nought():
    found = errors_of(recorded(np.zeros((4000, 3))), GaussMarkov(FORGETS, 0.015))
    assert set(found) == {"position", "rotation"}
    for part, error in found.items():
        assert np.abs(error).max() < 2e-5, part  # the spline that a measured rate is read off, and a difference's h^2


@pytest.mark.parametrize("seed", range(3))
def test_rows_of_errors_that_wander_are_white_and_as_large_as_the_errors(seed):
    errors = wandering(4000, SIZE, seed=seed)
    every = 3
    found = errors_of(recorded(errors), GaussMarkov(FORGETS, every / RATE))
    for part, size in (("rotation", SIZE), ("position", 0.1 * SIZE)):
        rows = found[part][::every]
        assert rows.std() == pytest.approx(size, rel=0.15), part  # a smoothing over three samples takes a tenth
        along = np.mean(rows[1:] * rows[:-1]) / rows.var()
        assert abs(along) < 0.3, part
        assert np.mean(errors[every::every] * errors[:-every:every]) / errors.var() > 0.8  # the errors are not


def with_mean_pose(recording, width):
    """The same recording, each sample of its pose the mean of the true ones in a window of so many samples."""
    (pose,) = recording.poses
    later = (np.arange(width) - (width - 1) / 2) / RATE
    now = quaternion(turned(pose.time))
    each = [quaternion(turned(pose.time + d)) for d in later]
    q = sum(x * np.sign(np.sum(x * now, axis=1, keepdims=True)) for x in each)
    place = np.mean([moved(pose.time + d) for d in later], axis=0)
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    return replace(recording, poses=(replace(pose, position=place, quaternion=q),))


@pytest.mark.parametrize("wander", [None, GaussMarkov(FORGETS, 0.015)], ids=["white", "lasting"])
def test_rows_of_a_smoothed_pose_are_nought_beside_half_the_variance_of_its_window(wander):
    """Of 3 Hz and a window of 35 ms a hundredth is left of what smoothing does: terms of fourth order."""
    width = 7
    recording = with_mean_pose(recorded(np.zeros((4000, 3))), width)
    window = (width**2 - 1) / 24 / RATE**2
    without, with_it = errors_of(recording, wander), errors_of(recording, wander, window)
    for part in ("position", "rotation"):
        inner = slice(50, -50)
        assert np.abs(with_it[part][inner]).max() < 0.05 * np.abs(without[part][inner]).max(), part


@pytest.mark.parametrize("seed", range(3))
def test_how_errors_wander_is_read_off_the_gyroscope(seed):
    masks, wander = correlated_poses(recorded(wandering(4000, SIZE, seed=seed), bias=0.01))
    assert wander["pose1"].rate == pytest.approx(FORGETS, rel=0.5)  # 20 s hold 200 of its lives, in three axes
    counts = masks["pose1.rotation"]
    assert np.diff(np.flatnonzero(counts)).max() * 1 / RATE == pytest.approx(wander["pose1"].step)
    assert wander["pose1"].step <= 0.02  # smoothed over 0.015 s


def test_independent_errors_do_not_wander():
    white = SIZE * np.random.default_rng(1).standard_normal((4000, 3))
    assert correlated_poses(recorded(white)) == ({}, {})


def optical_record(ahead=0.0, width=1):
    """15 s of a free body with everything that an IMU reads, beside an optical pose; nobody declares a noise.

    The accelerometer is `ahead` s of the gyroscope, and each sample of the pose the mean over `width` samples.
    """
    rng = np.random.default_rng(8)
    errors = wandering(4000, SIZE, seed=5)
    recording = recorded(errors, bias=BIAS)
    (imu,), h = recording.imus, 1e-3
    t = imu.time + ahead
    acceleration = (moved(t + h) - 2 * moved(t) + moved(t - h)) / h**2
    force = turned(t).inv().apply(acceleration + np.array([0.0, 0.0, 9.81]))
    imu = replace(imu, accel=force + 0.02 * rng.standard_normal(force.shape), mount_rotation_std=0.01)
    (pose,) = with_mean_pose(recording, width).poses
    q = rotations.multiply(pose.quaternion, rotations.exp(errors))
    pose = replace(pose, position=pose.position + 0.1 * errors, quaternion=q)
    return cut(replace(recording, imus=(imu,), poses=(pose,)), 2.0, 17.0)


@pytest.fixture(scope="module")
def optical():
    return optical_record()


AHEAD, WIDTH = 1.5e-3, 7  # s, samples


@pytest.fixture(scope="module")
def filtered():
    return optical_record(AHEAD, WIDTH)


@pytest.mark.long
def test_what_filters_and_smoothing_do_is_told_beside_the_motion(filtered):
    fit = begin(filtered).fit
    covariance = information(fit)[0]
    smoothing = (WIDTH**2 - 1) / 24 / RATE**2
    for name, true in (("accel_ahead@imu1.ahead", AHEAD), ("pose1.smoothing", smoothing)):
        std = np.sqrt(covariance[fit.model.parameters.columns(name), fit.model.parameters.columns(name)][0, 0])
        assert abs(fit.state.values[name][0] - true) < 4 * std + 0.03 * true, name  # terms of fourth order
        assert std < 0.05 * true, name


@pytest.mark.slow
def test_neither_is_a_finding(filtered):
    found, _ = diagnose(filtered)
    assert {(f.effect, f.at) for f in found.findings} <= {("gyro_bias", "imu1")}


@pytest.mark.long
def test_a_gyroscope_beside_errors_that_wander_keeps_its_own_noise(optical):
    fit = begin(optical).fit
    assert fit.noise["imu1.gyro"] == pytest.approx(2e-3, rel=0.2)  # taken for independent they make it three times that


@pytest.mark.slow
def test_a_bias_beside_errors_that_wander_is_all_that_is_found(optical):
    found, _ = diagnose(optical)
    (bias,) = found.findings
    assert (bias.effect, bias.at) == ("gyro_bias", "imu1")
    assert np.all(np.abs(bias.parameters["bias"].value - BIAS) < 4 * bias.parameters["bias"].std)


def test_a_row_is_linear_in_what_it_says_it_depends_on():
    recording = recorded(wandering(4000, SIZE))
    short = replace(
        recording,
        imus=tuple(replace(i, time=i.time[:60], gyro=i.gyro[:60], accel=i.accel[:60]) for i in recording.imus),
        poses=tuple(replace(p, time=p.time[:60], position=p.position[:60], quaternion=p.quaternion[:60])
                    for p in recording.poses),
    )  # fmt: skip
    fit = nominal_fit(short, wander={"pose1": GaussMarkov(FORGETS, 0.015)})
    model, rng = fit.model, np.random.default_rng(0)
    change = rng.standard_normal(fit.state.coefficients.shape) * 1e-6

    def rows(sign):
        state = State(fit.state.coefficients + sign * change, fit.state.values)
        return {r.name: r for r in all_rows(model, state, fit.noise, fit.anchor) if r.name.startswith("pose1.")}

    up, down, here = rows(1), rows(-1), rows(0)
    assert set(here) == {"pose1.position", "pose1.rotation"}
    for name, r in here.items():
        slope = np.zeros_like(r.residual.value)
        for (track, order), block in r.residual.blocks.items():
            if track in model.tracks.widths:
                own = model.tracks.columns(track)
                first, weights = model.tracks.knots.weights(r.time, order)
                part = np.einsum("ns,nsk->nk", weights, change[first[:, None] + np.arange(6)][:, :, own])
                slope += np.einsum("nmk,nk->nm", np.broadcast_to(block, (len(part), *block.shape[1:])), part)
        found = (up[name].residual.value - down[name].residual.value) / 2
        assert np.abs(found - slope).max() < 1e-2 * np.abs(slope).max(), name  # a turn's vector is of second order


@pytest.mark.long
def test_a_report_says_what_the_fit_knows_of_the_timing(filtered):
    ahead, smoothed = beside_motion(begin(filtered).fit)
    assert "imu1 that is ahead of its gyroscope: ahead +1.5" in ahead
    wide = float(smoothed.split("by a window of ")[1].split()[0])
    assert wide == pytest.approx(10.0, rel=0.03)  # ms, of 7 samples at 200 Hz; terms of fourth order
