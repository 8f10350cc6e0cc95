"""A noise that nobody declares: seen at rest, not in a moving hand or on foam, and never more than an IMU can have."""

import numpy as np
import pytest

from imubench.diagnosis.evidence import Level
from imubench.diagnosis.residual_checks.fit_summary import noise_of
from imubench.diagnosis.result import Finding, Interval
from imubench.diagnosis.samples.quiet_moments import quiet_level
from imubench.diagnosis.samples.rest_noise import MOST_REST_STD, quiet_noise, rest_noise
from imubench.diagnosis.samples.screening import check_samples
from imubench.diagnosis.verdict.posterior import verdict_of
from imubench.format1 import read
from imubench.proof.case import make_case
from imubench.recording import Imu

RATE = 50.0
TIME = np.arange(150) / RATE
TRUE = {"gyro": 0.002, "accel": 0.02}
NO_STEPS = {"gyro": np.zeros(3), "accel": np.zeros(3)}


def still(times=1.0, gyro=0.0, accel=0.0):
    """An IMU at rest for three seconds, its noise so many times as loud, with a motion (n,) on every axis."""
    rng = np.random.default_rng(2)
    noise = {part: times * std * rng.normal(size=(TIME.size, 3)) for part, std in TRUE.items()}
    g = noise["gyro"] + 0.01 + np.reshape(gyro, (-1, 1))
    a = noise["accel"] + [0.0, 0.0, 9.81] + np.reshape(accel, (-1, 1))
    return Imu("imu1", TIME, g, a, RATE)


def at_rest(imu, end=3.0, steps=NO_STEPS):
    return rest_noise(imu, ((0.0, end),), steps)


def test_at_rest_the_noise_is_what_is_read():
    """450 numbers know a std to 3.3 %: three of these."""
    assert at_rest(still()) == {part: pytest.approx(std, rel=0.1) for part, std in TRUE.items()}


@pytest.mark.parametrize(
    "imu",
    [
        still(gyro=0.003 * np.sin(2 * np.pi * 2.0 * TIME)),
        still(gyro=0.003 * np.sin(2 * np.pi * 9.0 * TIME)),
        still(accel=0.04 * np.sin(2 * np.pi * 14.0 * TIME)),
        still(gyro=0.15),
        still(times=20.0),
    ],
    ids=["a hand that sways", "a hand that trembles", "foam that rings", "a steady turn", "louder than any IMU"],
)
def test_what_moves_is_not_at_rest(imu):
    assert at_rest(imu) == {}


def test_a_rest_that_is_short_shows_no_noise():
    assert at_rest(still(), end=0.5) == {}


def test_readings_that_stand_still_have_the_noise_of_their_rounding():
    imu = still()
    coarse = Imu("imu1", TIME, 0.05 * np.round(imu.gyro / 0.05), imu.accel, RATE)
    found = at_rest(coarse, steps={"gyro": np.full(3, 0.05), "accel": np.zeros(3)})
    assert found["gyro"] == pytest.approx(0.05 / np.sqrt(12))


@pytest.mark.parametrize("part", ["gyro", "accel"])
def test_a_quiet_moment_that_is_none_counts_as_no_more_than_an_imu_has(part):
    loud = still(times=100.0)
    assert quiet_level(TIME, getattr(loud, part)) > 2 * MOST_REST_STD[part]
    assert quiet_noise(loud, part) == MOST_REST_STD[part]
    assert quiet_noise(still(), part) == quiet_level(TIME, getattr(still(), part))
    swung = 2.0 * np.round(20 * np.sin(np.outer(TIME, [5.0, 6.0, 7.0])))
    rounded = quiet_noise(Imu("imu1", TIME, swung, swung, RATE), part)
    assert rounded == pytest.approx(2.0 / np.sqrt(12), rel=1e-6)  # rounding may be louder than any noise


@pytest.mark.parametrize(
    ("options", "source"),
    [({}, "declared"), ({"declare_noise": False}, "rest"), ({"declare_noise": False, "rest": 0.0}, "unknown")],
)
def test_where_each_noise_is_known_from(options, source, tmp_path):
    """On the independent generator's recordings; at rest within 10 %, of which a rest of 1.5 s tells a third."""
    make_case(tmp_path / "r", "hinge", seed=5, **({"seconds": 20.0, "rate": RATE, "rest": 0.5} | options))
    recording = read(tmp_path / "r")[0]
    samples = check_samples(recording)
    levels = [
        Level(f"{imu.name}.{part}", "", getattr(imu, f"{part}_noise_std"), samples.white[f"{imu.name}.{part}"], 1.0)
        for imu in recording.imus
        for part in TRUE
    ]
    found = noise_of(levels, recording, samples.rest)
    assert {n.source for n in found.values()} == {source}
    if source == "rest":
        for name, std in samples.rest.items():
            assert std == pytest.approx(TRUE[name.split(".")[1]], rel=0.1), name


def test_beside_a_noise_that_is_unknown_nothing_is_explained():
    named = (Finding("gyro_bias", "imu1", 0.9, {}, Interval(9.0, (8.0, 9.0))),)
    assert verdict_of(named, ()) == "explained"
    assert verdict_of(named, (), ["imu1.gyro"]) == "partly explained"
    assert verdict_of((), (), ["imu1.gyro"]) == "no mismatch"
