"""When an optical record was taken, from how fast things turn: offsets of either sign, gaps, drift, and how sure."""

import numpy as np
import pytest

from imubench.errors import InputError
from imubench.recording import Imu
from imubench.rotations import exp, multiply
from imubench.timing import on_imu_clock, optical_timing
from tests.chain import chain_quaternions, readings

IMU_RATE, OPTICAL_RATE = 40.0, 30.0  # Hz, as in diodem
SECONDS = 40.0


def pairs_of(late=0.0, drift=0.0, segments=(0, 2), seed=0, gyro_noise=0.01, optical_noise=0.002, gaps=(), rocking=0.0):
    """IMUs of a made-up chain, with what cameras whose stamps are `late` and drift saw of their segments."""
    rng = np.random.default_rng(seed)
    time = np.arange(round(SECONDS * IMU_RATE)) / IMU_RATE
    stamps = np.arange(round(SECONDS * OPTICAL_RATE)) / OPTICAL_RATE
    at = stamps - late - drift * (stamps - SECONDS / 2)
    made = []
    for k in segments:
        gyro, accel = readings(time, k)
        gyro = gyro + gyro_noise * rng.normal(size=gyro.shape)
        gyro = gyro + rocking * np.sin(2 * np.pi * 12.3 * time + rng.uniform(0, 6, 3)[:, None]).T
        q = multiply(chain_quaternions(at)[k], exp(optical_noise * rng.normal(size=(stamps.size, 3))))
        for first, last in gaps:
            q[(stamps > first) & (stamps < last)] = np.nan
        made.append((Imu(f"segment {k + 1}", time, gyro, accel, IMU_RATE), stamps, q))
    return made


@pytest.mark.parametrize("late", [-0.21, -0.0023, 0.0, 0.0162, 0.12, 0.43])
def test_offsets_of_either_sign_are_found(late):
    timing = optical_timing(pairs_of(late))
    assert timing.late == pytest.approx(late, abs=4 * timing.std)
    assert timing.std < 1e-3  # s: a thirtieth of a frame; 0.1 to 0.4 ms by how the two IMUs happen to differ
    assert timing.known and not timing.drifts
    stamps = np.arange(1200) / OPTICAL_RATE
    np.testing.assert_allclose(timing.applied(stamps), stamps - timing.late)


@pytest.mark.long
def test_offsets_are_as_far_off_as_they_say():
    errors = [(t.late - 0.0162) / t.std for t in (optical_timing(pairs_of(0.0162, seed=s)) for s in range(20))]
    assert 0.5 < np.sqrt(np.mean(np.square(errors))) < 1.7  # 20 of them: 1 +- 0.16, and stds of ten blocks +- 0.2


def test_gaps_and_wild_frames_do_not_move_it():
    pairs = pairs_of(-0.0023, gaps=((3.0, 5.5), (20.0, 20.2), (33.0, 36.0)))
    for _, _, q in pairs:
        q[::97] = q[::97] * [1.0, -1.0, 1.0, 1.0]  # frames in which markers were mistaken for others
        q[::97] /= np.linalg.norm(q[::97], axis=1, keepdims=True)
    timing = optical_timing(pairs)
    assert timing.late == pytest.approx(-0.0023, abs=max(4 * timing.std, 4e-4))


def test_imus_that_rock_are_averaged():
    timing = optical_timing(pairs_of(0.0162, segments=(0, 1, 2, 3, 4), rocking=0.3))
    assert timing.imus == 5
    assert timing.late == pytest.approx(0.0162, abs=4 * timing.std)
    assert timing.std < 2e-3  # s: a tenth of what is to be found


def test_clocks_that_drift_apart_are_put_right():
    """50 ppm of 40 s are 2 ms: more than the offset is unsure of; hundredths of it are not seen."""
    drift = 1e-4
    timing = optical_timing(pairs_of(0.01, drift))
    assert timing.drifts
    assert timing.drift == pytest.approx(drift, abs=4 * timing.drift_std)
    stamps = np.arange(1200) / OPTICAL_RATE
    true = stamps - 0.01 - drift * (stamps - SECONDS / 2)
    np.testing.assert_allclose(timing.applied(stamps), true, atol=3e-4)  # s, as the offset's std
    assert not optical_timing(pairs_of(0.01, drift / 100)).drifts


def test_a_drift_with_gaps_in_one_half_only():
    timing = optical_timing(pairs_of(-0.05, 1e-4, gaps=((22.0, 30.0),)))
    assert timing.drift == pytest.approx(1e-4, abs=4 * timing.drift_std)


def test_where_nothing_turns_the_stamps_stay():
    time, stamps = np.arange(1600) / IMU_RATE, np.arange(1200) / OPTICAL_RATE
    rng = np.random.default_rng(0)
    imu = Imu("imu1", time, 0.01 * rng.normal(size=(1600, 3)), np.tile([0, 0, 9.81], (1600, 1)), IMU_RATE)
    q = exp(0.002 * rng.normal(size=(1200, 3)))
    put, said = on_imu_clock([(imu, stamps, q)], stamps)
    np.testing.assert_array_equal(put, stamps)
    assert "not sure enough" in said


def test_a_given_offset_wins_and_the_data_are_told():
    stamps = np.arange(1200) / OPTICAL_RATE
    put, said = on_imu_clock(pairs_of(0.0162), stamps, given=-0.004)
    np.testing.assert_allclose(put, stamps + 0.004)
    assert said.startswith("Optical stamps taken -4 ms earlier than written, as told; by the data +16.")


def test_too_little_in_view():
    pairs = pairs_of(gaps=((0.5, 39.9),))
    with pytest.raises(InputError, match=r"optical record of segment 1: expected 50 frames or more in view, got \d+"):
        optical_timing(pairs)


@pytest.mark.parametrize(
    ("times", "turns", "said"),
    [
        (1e-6, 1.0, "expected samples 1e-06 to 100000 s apart"),
        (1e200, 1.0, "expected samples 1e-06 to 100000 s apart"),  # squares of such steps overflow
        (1.0, 1e9, "expected rates below 1e\\+06 rad/s"),
    ],
)
def test_steps_and_rates_of_no_imu_are_refused(times, turns, said):
    ((imu, stamps, q),) = pairs_of(segments=(0,))
    odd = Imu(imu.name, imu.time * times, imu.gyro * turns, imu.accel, imu.rate)
    with pytest.raises(InputError, match=f"segment 1: {said}"):
        optical_timing([(odd, stamps, q)])


def test_one_frame_times_nothing():
    ((imu, stamps, q),) = pairs_of(segments=(0,))
    with pytest.raises(InputError, match="expected 50 frames or more in view, got 0"):
        optical_timing([(imu, stamps[:1], q[:1])])
