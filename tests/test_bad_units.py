"""Samples in another unit are refused in one line that names it; harsh samples in the right one are read."""

from pathlib import Path

import numpy as np
import pytest

from imubench import rotations
from imubench.convert import CONVERTERS
from imubench.format1 import read, read_recording, write_recording
from imubench.format1.physics_checks import turning_ratio
from imubench.recording import Imu
from tests.damage import TIME, N, change, refused, swap


def test_degrees_beyond_the_declared_range(good):
    change(good, "imu1.csv", "gyr", lambda gyro: gyro * 4 * 180 / np.pi)
    refused(
        good,
        "rec/imu1.csv, line ",
        "column 'gyr_x': expected at most 1.5 times the declared range of 35 rad/s, got 52.",
        "probably deg/s",
    )


def test_degrees_beyond_any_gyroscope(good):
    change(good, "imu2.csv", "gyr", lambda gyro: gyro * 4 * 180 / np.pi)
    refused(good, "imu2.csv, line ", "expected |gyr| under 70 rad/s, the limit of such sensors", "probably deg/s")


def test_counts_beyond_any_gyroscope(good):
    change(good, "imu2.csv", "gyr", lambda gyro: gyro * 16.4 * 10 * 180 / np.pi)
    refused(good, "expected |gyr| under 70 rad/s", "probably raw counts")


def test_slow_motion_in_degrees_is_told_by_gravity(good):
    change(good, "imu2.csv", "gyr", lambda gyro: gyro * 180 / np.pi)  # 29 deg/s: no gyroscope's limit says it
    refused(good, "rec/imu2.csv, line 2: expected gyr in rad/s, got rates 57", "as fast as gravity turns in acc")


@pytest.mark.parametrize(
    ("unit", "factor"), [("g", 1 / 9.80665), ("mg", 1e3 / 9.80665), ("raw counts", 2048 / 9.80665)]
)
def test_specific_force_at_rest_far_from_g(good, unit, factor):
    change(good, "imu2.csv", "acc", lambda accel: accel * factor)
    refused(good, "rec/imu2.csv, line 2: expected |acc| of about 9.81 m/s^2 at rest, got ", f"probably {unit}")


def test_specific_force_beyond_the_declared_range(good):
    change(good, "imu1.csv", "acc", lambda accel: accel * 1e3 / 9.80665)
    refused(good, "imu1.csv, line 2, column 'acc_z': expected at most 1.5 times the declared range of 160 m/s^2", "mg")


@pytest.mark.parametrize(
    ("unit", "factor"), [("g", 1 / 9.80665), ("mg", 1e3 / 9.80665), ("raw counts", 2048 / 9.80665)]
)
def test_specific_force_of_another_unit_without_rest(good, unit, factor):
    shaken = 9.81 * np.tile([0, 0, 1], (N, 1)) + 5 * np.sin(TIME[:, None] * [20, 30, 40])
    change(good, "imu2.csv", "acc", lambda _: shaken)
    read(good)
    change(good, "imu2.csv", "acc", lambda _: shaken * factor)
    refused(good, "imu2.csv, line 2: expected |acc| in m/s^2, got a me", f"probably {unit}")


def test_specific_force_without_gravity(good):
    change(good, "imu2.csv", "acc", lambda accel: accel - accel)
    refused(good, "at rest, got 0: probably gravity was taken out")


@pytest.mark.parametrize(("unit", "factor"), [("milliseconds", 1e3), ("microseconds", 1e6), ("nanoseconds", 1e9)])
def test_time_in_another_unit(good, unit, factor):
    change(good, "imu1.csv", "time", lambda time: time * factor)
    refused(
        good,
        f"imu1.csv, line 3, column 'time': expected steps of about 0.01 s by the declared rate of 100 Hz, "
        f"got {0.01 * factor:g} s (median): probably {unit}",
    )


@pytest.mark.parametrize(
    ("new", "message"),
    [
        ("gyro_range = 2000", "key 'gyro_range': expected rad/s, under 100, got 2000: probably deg/s"),
        ("accel_range = 8", "key 'accel_range': expected m/s^2, from gravity (9.81) to 5000, got 8: probably g"),
        ("accel_range = 16000", "from gravity (9.81) to 5000, got 16000: probably mg or counts"),
        (
            "mount_position = [-100, 0, 20]",
            "key 'mount_position': expected a vector in m, under 10 m long",
        ),
    ],
)
def test_declared_facts_in_another_unit(good, new, message):
    text = (good / "recording.toml").read_text()
    text = text.replace("gyro_range = 35.0\n", "").replace("accel_range = 160.0\n", f"{new}\n")
    (good / "recording.toml").write_text(text)
    refused(good, "recording.toml, [[imu]] number 1", message)


def test_a_body_in_millimetres(good):
    swap(good, "recording.toml", "-0.25", "-250.0")
    refused(good, "recording.toml, [body], key 'com': expected a vector in m, under 10 m long", "probably mm")


@pytest.mark.parametrize(("file", "column"), [("encoder.csv", "angle"), ("reference.csv", "hinge_angle")])
def test_a_joint_angle_in_degrees(good, file, column):
    change(good, file, column, lambda angle: 90 * np.sin(2 * np.arange(N)[:, None] / 100))
    refused(good, f"rec/{file}, line ", f"column '{column}': expected rad, got ", "rad/s: probably degrees")


@pytest.mark.parametrize(("file", "column"), [("encoder.csv", "angle"), ("reference.csv", "hinge_angle")])
@pytest.mark.parametrize(("last", "said"), [(1e9, "expected rad, at most 1e+06, got 1e+09"), (5e3, "under 700 rad/s")])
def test_a_joint_angle_that_no_joint_has(good, file, column, last, said):
    """Three readings of 1,200 are too few to be a unit, but no joint turns by 800 turns in a tenth of a second."""
    change(good, file, column, lambda angle: np.append(angle[:-3], np.full((3, 1), last), axis=0))
    refused(good, f"rec/{file}, line ", f"column '{column}'", said)


def rated(folder: Path, rate: float) -> None:
    text = (folder / "recording.toml").read_text()
    (folder / "recording.toml").write_text(text.replace("rate = 100.0", f"rate = {rate}"))


def test_milliseconds_with_a_rate_to_match(good):
    """Rate and stamps agree, but no IMU has 0.1 Hz."""
    rated(good, 0.1)
    for file in ("imu1.csv", "imu2.csv"):
        change(good, file, "time", lambda time: 1e3 * time)
    refused(
        good, "rec/imu1.csv, line 3, column 'time': expected steps of an IMU's 0.2 to 50000 Hz, got 10 s (median)",
        "rate = 0.1: the stamps are probably milliseconds",
    )  # fmt: skip


@pytest.mark.parametrize(("factor", "unit"), [(1e3, "milliseconds"), (1e6, "microseconds"), (1e9, "nanoseconds")])
def test_stamps_since_1970_in_another_unit(good, factor, unit):
    rated(good, 100.0 / factor)
    for file in ("imu1.csv", "imu2.csv"):
        change(good, file, "time", lambda time: factor * (1.7e9 + time))
    refused(
        good, "rec/imu1.csv, line 2, column 'time': expected s, up to 9e+09, got 1.7", f"probably {unit} since 1970"
    )


def test_a_clock_that_was_set_while_it_recorded(good):
    for file in ("imu1.csv", "imu2.csv"):
        change(good, file, "time", lambda time: time + 1.7e9 * (time > 5))
    refused(
        good, "rec/imu1.csv, line 503, column 'time': expected at most 31 days from the first sample to the last",
        "got 1.968e+04, of them 1.968e+04 before this row: was the clock set?",
    )  # fmt: skip


def test_seconds_since_1970_are_data(good):
    for file in ("imu1.csv", "imu2.csv", "encoder.csv", "pose1.csv", "reference.csv"):
        change(good, file, "time", lambda time: 1.7e9 + time)
    swap(good, "recording.toml", "start = 1.0", "start = 1700000001.0")
    swap(good, "recording.toml", "end = 5.0", "end = 1700000005.0")
    assert read(good)[0].imus[0].time[0] == 1.7e9


def test_a_position_in_millimetres(good):
    change(good, "pose1.csv", "y", lambda _: 300 * np.sin(TIME[:, None]))
    refused(good, "rec/pose1.csv, line 2, position: expected m, got ", "probably millimetres")


# What must not be refused


def accepted(good: Path, gyro: np.ndarray, accel: np.ndarray, reaches: float) -> Imu:
    """Read the samples as imu2, with nothing declared, after a look that they are as harsh as their test says."""
    assert np.abs(gyro).max() > reaches
    change(good, "imu2.csv", "gyr", lambda _: gyro)
    change(good, "imu2.csv", "acc", lambda _: accel)
    return read_recording(good).imus[1]


def test_saturated_and_noisy_samples_are_data(good):
    change(good, "imu1.csv", "gyr", lambda gyro: np.clip(gyro * 200, -35, 35) * 1.2)
    assert np.abs(read_recording(good).imus[0].gyro).max() == pytest.approx(42)


def test_lost_samples_and_jitter_are_data(good):
    path = good / "imu1.csv"
    rng = np.random.default_rng(1)
    header, *lines = path.read_text().splitlines()
    kept = [line for line, keep in zip(lines, rng.random(N) > 0.5, strict=True) if keep]
    path.write_text("\n".join([header, *kept]) + "\n")
    change(good, "imu1.csv", "time", lambda time: time + rng.uniform(0, 0.009, time.shape))
    read(good)


def test_fast_motion_without_rest_is_data(good):
    rate = 33 * np.sin(TIME[:, None] * [7.0, 9.0, 11.0])
    accel = 9.81 * np.tile([0, 0, 1], (N, 1)) + 0.2 * rate**2 + 30 * np.cos(TIME[:, None] * [17, 19, 23])
    accepted(good, rate, accel, reaches=30)


@pytest.mark.parametrize("lever", [0.0, 0.5, 0.9, 0.98256, 1.0, 1.2])
@pytest.mark.parametrize("amplitude", [0.05, 0.25, 1.2])
def test_a_swinging_pendulum_is_data(good, lever, amplitude):
    """At the centre of oscillation (lever 1) specific force stays along the rod, whatever the rod does."""
    length = 0.5  # m
    angle = amplitude * np.cos(np.sqrt(9.81 / length) * TIME)
    rate = np.gradient(angle, TIME)
    r = lever * length
    along = 9.81 * np.cos(angle) + r * rate**2
    across = 9.81 * np.sin(angle) * (1 - lever)
    zero = np.zeros(N)
    gyro = np.stack([zero, rate, zero], axis=1)
    accepted(good, gyro, np.stack([across, zero, along], axis=1), reaches=amplitude)


@pytest.mark.parametrize("radius", [0.02, 0.2, 1.0])
def test_a_turntable_is_data(good, radius):
    """Spun up and down about the vertical: no rest, and gravity never turns in sensor axes."""
    rate = 3 + 2 * np.sin(TIME)
    zero = np.zeros(N)
    tilt = rotations.from_axis_angle(np.array([1.0, 0, 0]), 0.3)
    gyro = rotations.rotate_back(tilt, np.stack([zero, zero, rate], axis=1))
    accel = rotations.rotate_back(tilt, np.stack([-radius * rate**2, radius * 2 * np.cos(TIME), 9.81 + zero], axis=1))
    accepted(good, gyro, accel, reaches=4)


def test_a_short_fall_and_knocks_are_data(good):
    accel = 9.81 * np.tile([0.0, 0, 1], (N, 1))
    accel[300:370] = 0.0  # 0.7 s, 2.4 m
    accel[100::100] = 800.0
    gyro = np.full((N, 3), 0.02)
    gyro[50] = 200.0  # one bad sample is no unit
    accepted(good, gyro, accel, reaches=100)


def test_biased_sensors_at_rest_are_data(good):
    rng = np.random.default_rng(0)
    gyro = rng.normal([0.1, -0.2, 0.15], 0.02, size=(N, 3))  # 15 deg/s of bias
    accel = rng.normal([0.5, 0.5, 9.0], 0.2, size=(N, 3))
    accepted(good, gyro, accel, reaches=0.2)


def test_no_gravity_where_none_is_declared(good):
    swap(good, "recording.toml", 'rig = "hinge"', 'rig = "hinge"\ngravity = 0')
    for file in ("imu1.csv", "imu2.csv"):
        change(good, file, "acc", lambda accel: accel - accel)
    read(good)


def test_the_angle_of_a_joint_that_turns_many_times_is_data(good):
    change(good, "encoder.csv", "angle", lambda _: (30 * TIME[:, None] + np.pi) % (2 * np.pi) - np.pi)
    read(good)
    change(good, "encoder.csv", "angle", lambda _: 30 * TIME[:, None])
    read(good)


def test_a_spike_of_an_encoder_is_data(good):
    change(good, "encoder.csv", "angle", lambda angle: np.where(np.arange(N)[:, None] == 600, 60.0, angle))  # rad
    read(good)


def test_gravity_turns_as_fast_as_the_gyroscope_says():
    rate, zero = 3.0, np.zeros(N)
    accel = 9.81 * np.stack([zero, np.sin(rate * TIME), np.cos(rate * TIME)], axis=1)
    imu = Imu("imu1", TIME, np.stack([rate + zero, zero, zero], axis=1), accel, rate=100.0)
    slope, correlation, count = turning_ratio(imu, 9.81)
    assert slope == pytest.approx(1, rel=0.02)  # means over 0.1 s: second order in 3 rad/s x 0.1 s
    assert correlation > 0.999  # nothing but the same second order
    assert count == 23  # 119 steps between means over 0.1 s: 23 times five


@pytest.mark.parametrize("imu", ["rigid", "nonrigid"])
def test_real_recordings_pass_and_in_other_units_do_not(tmp_path, recordings, imu):
    (converted,) = CONVERTERS["diodem"](recordings / "diodem" / "trial1", segments="3-4", imu=imu)
    folder = tmp_path / "rec"
    write_recording(converted.recording, folder, converted.reference)
    read(folder)
    original = (folder / "imu2.csv").read_text()
    units = {
        "deg/s": ("gyr", 180 / np.pi), "g": ("acc", 1 / 9.81), "mg": ("acc", 1e3 / 9.81), "milliseconds": ("time", 1e3),
    }  # fmt: skip
    for unit, (columns, factor) in units.items():
        change(folder, "imu2.csv", columns, lambda values, factor=factor: values * factor)
        refused(folder, "rec/imu2.csv, line ", f"probably {unit}")
        (folder / "imu2.csv").write_text(original)
