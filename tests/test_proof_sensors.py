"""The generator's sensors against each law of the table: what is read, from what is true, seen from outside."""

import numpy as np
import pytest

from imubench import format1
from imubench.proof.case import build, make_case
from imubench.proof.frames import STEP, read_at
from imubench.proof.instruments import read_pose
from imubench.proof.rotation import from_quaternion, log
from imubench.proof.sensors import low_passed

QUIET = {"noise": 0.0, "seconds": 15.0, "geometry_error": False}
KEYS = {"gyro": "w", "accel": "f"}


def read(effects, at="imu2", rig="hinge", seed=3, **options):
    """The case, and stamps, readings and truth there of one IMU."""
    case = build(rig, effects, seed=seed, **{**QUIET, **options})
    i = int(at[-1]) - 1
    samples, track = case.imus[i], case.tracks[i]
    true = {channel: read_at(samples.time, getattr(track, key)) for channel, key in KEYS.items()}
    return case, samples, true


def test_without_effects_and_noise_a_sensor_reads_the_truth():
    _, samples, true = read([])
    assert np.array_equal(samples.gyro, true["gyro"]) and np.array_equal(samples.accel, true["accel"])


@pytest.mark.parametrize("channel", ["gyro", "accel"])
def test_parallel_errors_add_up(channel):
    """y = x + M x + s.x + b, and not one on the other."""
    effects = [
        (f"{channel}_bias", "imu2", {"bias": [0.1, -0.2, 0.3]}),
        (f"{channel}_scale", "imu2", {"scale": [0.01, 0.02, -0.03]}),
        (f"{channel}_misalignment", "imu2", {"matrix": [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]}),  # xy xz yx yz zx zy
    ]
    _, samples, true = read(effects)
    x, y, z = true[channel].T
    expected = [
        1.01 * x + 0.1 * y + 0.2 * z + 0.1, 0.3 * x + 1.02 * y + 0.4 * z - 0.2, 0.5 * x + 0.6 * y + 0.97 * z + 0.3
    ]  # fmt: skip
    assert np.allclose(getattr(samples, channel), np.stack(expected, -1), atol=1e-12)


def test_g_sensitivity_adds_specific_force_to_the_gyroscope():
    A = np.arange(1, 10).reshape(3, 3) * 1e-3
    _, samples, true = read([("g_sensitivity", "imu2", {"matrix": A}), ("accel_bias", "imu2", {"bias": [1, 1, 1]})])
    assert np.allclose(
        samples.gyro, true["gyro"] + np.einsum("ij,nj->ni", A, true["accel"]), atol=1e-12
    )  # the true one


def test_drift_grows_from_the_start():
    _, samples, true = read([("gyro_drift", "imu2", {"rate": [1e-3, 0, -2e-3]})])
    drift = samples.gyro - true["gyro"]
    assert not drift[0].any() and np.allclose(drift[-1] / (samples.time[-1] - samples.time[0]), [1e-3, 0, -2e-3])


@pytest.mark.parametrize("frequency", [2.0, 7.0, 20.0])
def test_the_low_pass_has_the_gain_and_phase_of_first_order(frequency):
    t, cutoff = STEP * np.arange(6000), 10.0
    y = low_passed(np.sin(2 * np.pi * frequency * t)[:, None] * np.ones(3), cutoff)[3000:, 0]
    basis = np.stack([np.sin(2 * np.pi * frequency * t[3000:]), np.cos(2 * np.pi * frequency * t[3000:])], -1)
    a, b = np.linalg.lstsq(basis, y, rcond=None)[0]
    answer = 1 / (1 + 1j * frequency / cutoff)
    assert abs((a + 1j * b) - answer) < 2e-3 * (frequency / 20) ** 2 + 1e-6  # lines between 1 ms points


def test_the_low_pass_takes_the_channels_that_it_names():
    _, samples, true = read([("low_pass", "imu2", {"cutoff": 3.0, "channels": ["accel"]})])
    assert np.array_equal(samples.gyro, true["gyro"]) and np.abs(samples.accel - true["accel"]).max() > 0.1


def test_offset_and_skew_move_the_world_under_the_stamps():
    offset, skew = 0.02, 5e-3
    effects = [("time_offset", "imu2", {"offset": offset}), ("clock_skew", "imu2", {"skew": skew})]
    case, samples, _ = read(effects)
    plain, _, _ = read([])
    assert np.array_equal(samples.time, plain.imus[1].time)
    there = (samples.time - offset) / (1 + skew)
    assert np.allclose(samples.accel, read_at(there, case.tracks[1].f), atol=1e-12)
    # an event of the world at 5 s carries the stamp 5 (1 + skew) + offset
    t = case.world.t
    event = np.argmax(np.where((t > 4) & (t < 6), case.tracks[1].w[:, 0], -np.inf))
    k = np.argmin(np.abs(samples.time - (t[event] * (1 + skew) + offset)))
    assert abs(samples.gyro[k, 0] - case.tracks[1].w[event, 0]) < 0.05


@pytest.mark.parametrize("channel", ["gyro", "accel"])
def test_noise_has_the_level_that_is_said(channel):
    std = {"gyro": 0.01, "accel": 0.3}[channel]
    _, samples, true = read([(f"{channel}_noise", "imu2", {"std": std})], noise=1.0, seconds=60.0)
    noise = getattr(samples, channel) - true[channel]
    assert abs(noise.std() / std - 1) < 0.03  # 18,000 numbers: 0.5 %
    assert np.abs(np.corrcoef(noise[1:].ravel(), noise[:-1].ravel())[0, 1]) < 0.03
    other = "accel" if channel == "gyro" else "gyro"
    usual = {"gyro": 0.002, "accel": 0.02}[other]
    assert abs((getattr(samples, other) - true[other]).std() / usual - 1) < 0.03


def test_coloured_noise_adds_a_fifth_of_the_power_below_a_few_hertz():
    _, samples, true = read([], "imu1", "free", noise=1.0, colour=0.2, seconds=300.0, rest=1.0)
    noise = samples.gyro - true["gyro"]
    assert abs(noise.var() / 0.002**2 - 1.2) < 0.03  # 90,000 numbers, correlated over some 20
    power = np.abs(np.fft.rfft(noise, axis=0)) ** 2
    frequency = np.fft.rfftfreq(len(noise), 0.01)
    slow, fast = (power[(frequency > a) & (frequency < b)].mean() for a, b in ((0.05, 0.5), (30, 50)))
    assert slow > 2 * fast


def test_the_declared_noise_is_wrong_by_what_was_asked(tmp_path):
    make_case(tmp_path / "a", seed=1, seconds=3, misdeclared=-0.15)
    make_case(tmp_path / "b", seed=1, seconds=3, declare_noise=False)
    assert format1.read_recording(tmp_path / "a").imus[0].gyro_noise_std == pytest.approx(0.0017)
    assert format1.read_recording(tmp_path / "b").imus[0].gyro_noise_std is None


def test_digital_faults():
    _, samples, true = read([("saturation", "imu2", {"limit": 2.0, "channels": ["gyro"]})])
    assert np.array_equal(samples.gyro, np.clip(true["gyro"], -2, 2)) and np.abs(samples.gyro).max() == 2.0
    _, samples, true = read([("quantisation", "imu2", {"step": 0.5, "channels": ["accel"]})])
    assert np.array_equal(samples.accel, 0.5 * np.round(samples.accel / 0.5))
    assert np.abs(samples.accel - true["accel"]).max() <= 0.25
    assert np.array_equal(samples.gyro, true["gyro"])


def test_dropped_samples_are_held_or_missing():
    _, plain, _ = read([])
    _, held, _ = read([("dropouts", "imu2", {"fraction": 0.2, "mode": "held"})])
    same = (np.diff(held.gyro, axis=0) == 0).all(axis=1) & (np.diff(plain.gyro, axis=0) != 0).any(axis=1)
    still = (np.diff(plain.gyro, axis=0) == 0).all(axis=1).mean()
    assert np.array_equal(held.time, plain.time) and abs(same.mean() - 0.2 * (1 - still)) < 0.04  # binomial
    _, missing, _ = read([("dropouts", "imu2", {"fraction": 0.2, "mode": "missing"})])
    assert abs(len(missing.time) / len(plain.time) - 0.8) < 0.04
    kept = np.isin(plain.time, missing.time)
    assert np.array_equal(plain.gyro[kept], missing.gyro)


def test_a_hum_is_a_line_at_its_frequency():
    p = {"frequency": 130.0, "amplitude": [0.5, 0.0, -0.2]}
    _, samples, true = read([("vibration", "imu2", p)], seconds=40.0)
    hum = samples.accel - true["accel"]
    assert np.allclose(hum.std(axis=0) * np.sqrt(2), [0.5, 0, 0.2], atol=0.01)  # whole periods only on average
    assert np.allclose(hum[:, 2], -0.4 * hum[:, 0])
    power = np.abs(np.fft.rfft(hum[:, 0])) ** 2
    rate = (len(samples.time) - 1) / (samples.time[-1] - samples.time[0])
    image = abs(130.0 - rate)  # sampled at about 100 Hz
    assert abs(np.fft.rfftfreq(len(hum), 1 / rate)[power.argmax()] - image) < 0.1
    assert np.array_equal(samples.gyro, true["gyro"])


def test_knocks_are_short_and_at_their_times():
    times = [3.0, 7.5, 12.0]
    _, samples, true = read([("impacts", "imu2", {"times": times, "peak": 60.0})])
    knock = np.linalg.norm(samples.accel - true["accel"], axis=1)
    since = samples.time[:, None] - times
    near = ((since > 0) & (since < 0.06)).any(axis=1)
    assert knock[~near].max() < 0.05 * knock.max() and knock.max() > 15
    for k in range(3):
        assert knock[(since[:, k] > 0) & (since[:, k] < 0.06)].max() > 10


def test_own_clocks_and_rates():
    case = build("hinge", [], seed=3, rate=128.0, rate2=60.0, **QUIET)
    first, second = (samples.time for samples in case.imus)
    for time, rate in ((first, 128.0), (second, 60.0)):
        assert np.allclose(np.diff(time), np.mean(np.diff(time)))
        assert abs(np.mean(np.diff(time)) * rate - 1) < 0.0031 and 0 <= time[0] < 1 / rate


def test_a_measured_pose_is_the_segments():
    case = build("free", [], seed=3, **{**QUIET, "noise": 1.0})
    table = read_pose(case.world.segments[0], "segment1", case.options, case.seed)["columns"]
    seen = np.isfinite(table["x"])
    time, track = table["time"][seen], case.world.segments[0]
    p = np.stack([table[k][seen] for k in "xyz"], -1)
    R = from_quaternion(np.stack([table[k][seen] for k in ("qw", "qx", "qy", "qz")], -1))
    assert abs((p - read_at(time, track.p)).std() / 1e-3 - 1) < 0.05
    assert abs(log(np.swapaxes(read_at(time, track.R), 1, 2) @ R).std() / 4e-3 - 1) < 0.05
    assert 0.85 < seen.mean() <= 1


def test_the_same_motion_and_noise_whatever_the_effect():
    """So that a difference between two cases is the effect's alone."""
    plain, _, _ = read([], noise=1.0)
    with_it, _, _ = read([("gyro_bias", "imu2", {"bias": [0.1, 0.2, 0.3]})], noise=1.0)
    assert np.allclose(with_it.imus[1].gyro - plain.imus[1].gyro, [0.1, 0.2, 0.3], atol=1e-12)
    assert np.array_equal(with_it.imus[1].accel, plain.imus[1].accel)
