"""Too few samples, or too short a stretch: refused in one line or `not identifiable`, never `converged`.

A fit of as many samples as unknowns leaves no residual, and seemed certain: two samples of one IMU beside 3,000 of the
other gave `converged`, 84 deg off; 30 samples in 0.3 s gave axes 80 deg off.
"""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.hinge_rigs import random_rig
from benchmarks.pendulum_runs import circling
from imubench.errors import InputError
from imubench.estimators import ESTIMATORS
from imubench.estimators.extent import SHORTEST, SPARE, too_short
from imubench.paired import paired
from imubench.recording import Imu, Recording

NOISE = 0.002, 0.02  # rad/s, m/s^2
COUNTS = (1, 2, 3, 4, 5, 8, 13, 30, 60)  # samples at 100 Hz: all in less than a second


def whole(name: str, seed: int) -> Recording:
    rng = np.random.default_rng(seed)
    if ESTIMATORS[name].imus == 1:
        return circling(rng, duration=30.0).recording()
    return random_rig(rng, lever=0.05).noisy(rng, *NOISE).recording()


def cut(imu: Imu, first: int, count: int) -> Imu:
    rows = slice(first, first + count)
    return replace(imu, time=imu.time[rows], gyro=imu.gyro[rows], accel=imu.accel[rows])


def judged(name: str, recording: Recording) -> str:
    """Return the status of an estimate, or `refused`."""
    try:
        answer = ESTIMATORS[name].estimate(recording)
    except InputError as error:
        assert len(str(error).splitlines()) == 1
        return "refused"
    if answer.status == "not identifiable":
        assert answer.covariance is None
        assert answer.no_covariance_because
    return answer.status


def some(name: str) -> Recording:
    if name == "qmt":
        pytest.importorskip("qmt", reason="needs the extra: pip install 'imubench[peers]'")
    return whole(name, 1)


@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("name", ESTIMATORS)
def test_a_short_recording_is_never_called_converged(name, count):
    recording = some(name)
    for first in (0, 1000):
        try:
            short = replace(recording, imus=tuple(cut(imu, first, count) for imu in recording.imus))
        except InputError:
            assert count == 1 and ESTIMATORS[name].imus == 2  # two clocks of one instant each do not overlap
            continue
        assert judged(name, short) in ("refused", "not identifiable")


@pytest.mark.parametrize("count", [2, 3, 30])
@pytest.mark.parametrize("short", [0, 1])
@pytest.mark.parametrize("name", [e.name for e in ESTIMATORS.values() if e.imus == 2])
def test_a_short_imu_beside_a_long_one_is_never_called_converged(name, short, count):
    imus = list(some(name).imus)
    imus[short] = cut(imus[short], 1200, count)
    assert judged(name, Recording("r", "hinge", tuple(imus))) in ("refused", "not identifiable")


@pytest.mark.parametrize("name", [e.name for e in ESTIMATORS.values() if e.imus == 2])
def test_one_common_sample_is_no_trace(name):
    recording = some(name)
    one, two = (cut(imu, 0, 2) for imu in recording.imus)
    shifted = replace(two, time=two.time + 0.005)
    apart = Recording("r", "hinge", (one, shifted))
    assert paired(apart).time.size == 1
    assert judged(name, apart) in ("refused", "not identifiable")


def test_the_reason_names_what_is_missing():
    recording = whole("olsson2020", 1)
    few = replace(recording, imus=tuple(cut(imu, 0, 6) for imu in recording.imus))
    answer = ESTIMATORS["olsson2020"].estimate(few)
    assert answer.no_covariance_because == "6 samples are too few for 4 unknowns and their noise, 14 are needed"
    brief = replace(recording, imus=tuple(cut(imu, 0, 50) for imu in recording.imus))
    answer = ESTIMATORS["olsson2020"].estimate(brief)
    assert answer.no_covariance_because == "50 samples in 0.5 s are too short a stretch: 1 s of motion is needed"


def test_a_second_of_samples_at_any_rate_is_enough_if_they_are_more_than_the_unknowns():
    for rate in (50.0, 100.0, 1000.0):
        stamps = 1.7e9 + np.arange(round(SHORTEST * rate)) / rate  # s, of an epoch: rounded to 0.2 us
        assert not too_short(stamps, 4)
        assert too_short(stamps[:-1], 4)
    assert not too_short(np.arange(4.0 + SPARE), 4)
    assert too_short(np.arange(3.0 + SPARE), 4)


@pytest.mark.long
@pytest.mark.parametrize("name", ["olsson2020", "seel2012"])
def test_an_axis_from_one_second_is_what_it_claims(name):
    """Of an exact rig, 24 stretches of a second each: none is off by more than five of its own sigma and 1 deg."""
    for seed in range(12):
        rng = np.random.default_rng(seed)
        rig = random_rig(rng, lever=0.0).noisy(rng, *NOISE)
        for first in (500, 2000):
            recording = rig.recording()
            second = replace(recording, imus=tuple(cut(imu, first, 100) for imu in recording.imus))
            answer = ESTIMATORS[name].estimate(second)
            if answer.status != "converged":
                continue
            signs = np.sign(np.sum(answer.value * rig.axes, axis=1))[:, None]
            off = np.linalg.norm(signs * answer.value - rig.axes, axis=1).max()
            sigma = np.sqrt(np.linalg.eigvalsh(answer.covariance)[-1])
            assert off < 5 * sigma + np.deg2rad(1.0)
