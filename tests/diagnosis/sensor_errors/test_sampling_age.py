"""A sensor that renews its readings at its own pace: how old its samples are, told from what they read."""

from dataclasses import replace

import numpy as np
import pytest

from imubench.diagnosis.sensor_errors.sampling_age import aged_by, ages_of, of_one_age
from imubench.proof.case import build
from imubench.proof.frames import read_at
from imubench.proof.instruments import read_pose
from imubench.recording import Imu, Pose, Recording

RATE, RENEWED = 2000 / 7, 999.74  # Hz: every 3.5 ms a sensor is read that renews its readings about every one
LATER = 0.33  # of an interval, by which the accelerometer is renewed later


def ages(time, rate, phase):
    """How old readings (n,) s are at some times: a sawtooth."""
    return np.mod(rate * time + phase, 1.0) / rate


def recorded(seed, renewed=RENEWED, rate=RATE, seconds=20.0, **options):
    """A free body's recording whose samples are as old as their sensor's pace makes them; None: all of one age."""
    case = build("free", seed=seed, seconds=seconds, rate=rate, rest=0.0, **options)
    samples, track = case.imus[0], case.tracks[0]
    gyro, accel, since = samples.gyro, samples.accel, samples.time - samples.time[0]
    if renewed is not None:
        for part, signal, phase in (("gyro", track.w, 0.2), ("accel", track.f, 0.2 + LATER)):
            old = read_at(samples.time - ages(since, renewed, phase), signal) - read_at(samples.time, signal)
            gyro, accel = (gyro + old, accel) if part == "gyro" else (gyro, accel + old)
    columns = read_pose(case.world.segments[0], "segment1", case.options, seed)["columns"]
    time, *rest = columns.values()
    place = np.stack(rest, axis=1)
    pose = Pose("segment1", time, place[:, :3], place[:, 3:])
    return Recording("r", "free", (Imu("imu1", samples.time, gyro, accel, rate),), poses=(pose,)), track


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("renewed", [RENEWED, 2000 - RENEWED], ids=["slower", "faster"])
def test_the_pace_is_found_and_beside_a_pose_which_way_ages_grow(seed, renewed):
    recording, _ = recorded(seed, renewed, band=8.0, vigour=6.0, noise=0.1)
    (line,) = ages_of(recording.imus[0], {}, recording.poses[0])["gyro"]
    assert line[0] == pytest.approx(renewed, abs=0.02)  # 20 s tell a frequency to a fraction of 0.05 Hz
    assert abs(np.angle(np.exp(2j * np.pi * (line[1] - 0.2)))) < 0.3  # rad; 0.05 ms of a millisecond


@pytest.mark.parametrize("seed", range(3))
def test_samples_of_one_age_are_what_is_left(seed):
    recording, track = recorded(seed, band=8.0, vigour=2.0, noise=0.0)
    time, since = recording.imus[0].time, recording.imus[0].time - recording.imus[0].time[0]
    noisy = replace(
        recording.imus[0], gyro=recording.imus[0].gyro + 1e-3 * np.random.default_rng(seed).normal(size=(len(time), 3))
    )
    out, said = of_one_age(replace(recording, imus=(noisy,)), {})
    assert len(said) == 1
    added = out.imus[0].gyro - noisy.gyro
    younger = read_at(time - 0.5 / RENEWED, track.w) - read_at(time - ages(since, RENEWED, 0.2), track.w)
    assert np.std(added - younger) < 0.15 * np.std(younger)  # the noise in a slope, and terms of second order


def test_without_a_pose_the_alternation_alone_is_taken_out():
    recording, _ = recorded(0, band=8.0, vigour=2.0)
    time = recording.imus[0].time - recording.imus[0].time[0]
    rate = 1 / np.median(np.diff(time))
    one, mirror = ages_of(recording.imus[0], {}, None)["gyro"]
    assert one[0] + mirror[0] == pytest.approx(7 * rate, abs=0.01)  # mirrored at three and a half times the rate
    assert min(abs(f - RENEWED) for f, _ in (one, mirror)) < 0.02
    change = np.diff(aged_by(time, (one, mirror)))
    assert np.median(np.abs(change)) == pytest.approx(0.5 / RENEWED, rel=0.05)  # from one sample to the next


@pytest.mark.parametrize("rate", [50.0, 100.0, RATE])
@pytest.mark.parametrize("seed", range(4))
def test_samples_of_one_age_are_left_as_they_are(seed, rate):
    recording, _ = recorded(seed, None, rate, band=8.0, vigour=2.0)
    out, said = of_one_age(recording, {})
    assert said == ()
    assert out.imus[0].gyro.tobytes() == recording.imus[0].gyro.tobytes()


@pytest.mark.parametrize(
    "effect",
    [
        ("vibration", "imu1", None),
        ("impacts", "imu1", None),
        ("dropouts", "imu1", None),
        ("saturation", "imu1", None),
        ("time_offset", "imu1", None),
        ("low_pass", "imu1", None),
        ("clock_skew", "imu1", None),
    ],
    ids=lambda e: e[0],
)
@pytest.mark.parametrize("seed", range(2))
def test_what_else_is_loud_above_a_motion_is_no_age(seed, effect):
    recording, _ = recorded(seed, None, effects=[effect], strength="strong")
    assert of_one_age(recording, {})[1] == ()
