"""Where what is found in the samples themselves acts."""

from dataclasses import replace

import numpy as np

from imubench.diagnosis.evidence import Comparison
from imubench.diagnosis.residual_checks.localize import locate
from imubench.diagnosis.result import Finding, Interval, Parameter
from imubench.diagnosis.simulation.lost_samples import lost, tones

TIME = np.arange(400) / 100
TURNING = 3.0 * np.sin(2 * np.pi * TIME)


def both(clipped, limit=2.0):
    """Two IMUs that read what is simulated and noise; one clips a gyroscope's axis."""
    noise, out = np.random.default_rng(0).normal(size=(12, TIME.size)), []
    for i, name in enumerate(
        f"imu{k}.{c}" for k in (1, 2) for c in ("gyr_x", "gyr_y", "gyr_z", "acc_x", "acc_y", "acc_z")
    ):
        read = np.clip(TURNING, -limit, limit) if name == clipped else TURNING
        out.append(Comparison(name, "rad/s", TIME, read + 0.01 * noise[i], TURNING, TURNING, 0.01))
    counts = np.abs(TURNING) < limit
    return out, {"imu1.gyro": np.ones(TIME.size, dtype=bool), "imu2.gyro": counts}


def test_what_clips_is_at_its_sensor_and_axis():
    (where,) = locate(lost(*both("imu2.gyr_y"), {"imu2"}), {}, noise=0.0)
    assert (where.at, next(iter(where.channels))) == ("imu2", "gyr_y")


def test_samples_that_are_lost_without_a_finding_say_nothing():
    assert lost(*both("imu2.gyr_y"), set()) == ()
    channels, masks = both("")
    assert lost(channels, {name: np.ones_like(mask) for name, mask in masks.items()}, {"imu1", "imu2"}) == ()


def test_a_hum_of_the_samples_is_where_it_is_largest():
    still = np.zeros(TIME.size)
    channels = [Comparison(f"imu1.acc_{axis}", "m/s^2", TIME, still, still, still, 0.01) for axis in "xyz"]
    size = Parameter(np.array([0.005, -0.03, 0.0]), np.zeros(3), "m/s^2")
    pitch = Parameter(np.array(23.0), np.array(0.1), "Hz")
    hum = Finding("vibration", "imu1", 0.9, {"frequency": pitch, "amplitude": size}, Interval(9.0, (8.0, 10.0)))
    (where,) = locate(tones(channels, [hum]), {}, noise=0.0)
    assert (where.at, next(iter(where.channels))) == ("imu1", "acc_y")
    assert tones(channels, [replace(hum, at="imu2")]) == ()
