"""Sampling, each error that acts on the signal, and drop-outs alone, against their own equations."""

import numpy as np
import pytest

from imubench.sim.imu_model import observe_imu
from imubench.sim.imu_profile import ChannelProfile
from tests.imu_signals import DENSE, TONES, imu, motion, moving, read, sensor_truth

# --- a perfect IMU, sampling -------------------------------------------------------------------------------


@pytest.mark.parametrize("start", [0.0, 12.345])
@pytest.mark.parametrize("decimation", [1, 4, 10])
def test_a_perfect_imu_returns_the_truth_bit_by_bit(decimation, start):
    truth = moving(start=start)
    truth.sensor("imu1").gyro[7] = -0.0  # even the sign of a zero
    got = read(truth, imu(rate=DENSE / decimation))
    assert got.time.tobytes() == np.ascontiguousarray(truth.time[::decimation]).tobytes()
    assert got.gyro.tobytes() == np.ascontiguousarray(truth.sensor("imu1").gyro[::decimation]).tobytes()
    assert got.accel.tobytes() == np.ascontiguousarray(truth.sensor("imu1").specific_force[::decimation]).tobytes()


def test_rates_that_do_not_divide_stay_within_the_bound_of_the_cubic():
    truth = moving(dense=200.0)
    got = read(truth, imu(rate=73.0))
    fourth = 3.0 * (2 * np.pi * TONES) ** 4 / 200.0**4  # h^4 max|f''''| of 3 sin(2 pi f t)
    error = np.abs(got.gyro - motion(got.time)[0])
    inner = (got.time > truth.time[1]) & (got.time < truth.time[-2])
    # the bounds in `interpolate`; 1e-12 is rounding
    assert (error[inner] <= 3 / 128 * fourth + 1e-12).all()
    assert (error <= fourth / 24 + 1e-12).all()
    assert np.allclose(np.diff(got.time), 1 / 73, rtol=0, atol=1e-12)  # rounding of times up to 4 s


def test_interpolation_error_falls_with_the_fourth_power_of_the_dense_step():
    def worst(dense):
        got = read(moving(dense=dense), imu(rate=73.0))
        return np.abs(got.gyro - motion(got.time)[0])[2:-2].max()

    # 16 in the limit; at 3 Hz and 100 Hz the next order and the sampled positions leave 10 %
    assert worst(100.0) / worst(200.0) == pytest.approx(16, rel=0.1)


def test_a_sample_stamped_t_shows_the_world_at_its_clocks_time():
    offset, skew = 0.25, 2e-3
    got = read(moving(), imu(rate=100.0, clock_offset=offset, clock_skew=skew))
    world = (got.time - offset) / (1 + skew)
    # contract, section 4; h^4 / 24 max|f''''| of 3 sin(2 pi f t) is the cubic's bound, 1e-12 the rounding
    assert (np.abs(got.gyro - motion(world)[0]) <= 3 * (2 * np.pi * TONES / DENSE) ** 4 / 24 + 1e-12).all()
    assert np.allclose(np.diff(got.time), 0.01, rtol=0, atol=1e-12)
    assert got.time[0] == offset
    assert world[-1] <= 4.0 < world[-1] + 0.01


def test_jitter_moves_the_instant_and_not_the_stamp():
    time = np.arange(20001) / DENSE
    ramp = np.outer(time, [1.0, 2.0, -3.0])
    got = observe_imu(sensor_truth(ramp, ramp), time, imu(rate=500.0, jitter_std=2e-4), np.random.default_rng(1))
    assert np.array_equal(got.time, time[::2])
    shift = (got.gyro - ramp[::2])[1:-1] / [1.0, 2.0, -3.0]
    assert np.allclose(shift, shift[:, :1], rtol=0, atol=1e-10)  # one instant for all axes; rounding of 60 rad/s
    assert np.allclose((got.accel - got.gyro)[1:-1], 0, rtol=0, atol=1e-12)  # and for both channels
    assert shift[:, 0].std() == pytest.approx(2e-4, rel=0.04)  # 10,000 draws: std known to 0.7 %
    assert abs(shift[:, 0].mean()) < 8e-6  # four standard errors of 2e-4 / sqrt(10,000)


# --- errors that act on the signal -------------------------------------------------------------------------


def test_scale():
    truth = moving()
    got = read(truth, imu(ChannelProfile(scale=[0.1, -0.2, 0.3]), ChannelProfile(scale=[0.0, 0.5, 0.0])))
    # rounding only
    assert np.allclose(got.gyro, truth.sensor("imu1").gyro * [1.1, 0.8, 1.3], rtol=1e-14, atol=1e-15)
    assert np.allclose(got.accel, truth.sensor("imu1").specific_force * [1.0, 1.5, 1.0], rtol=1e-14, atol=1e-15)


@pytest.mark.parametrize(
    ("entry", "output", "source"), [(0, 0, 1), (1, 0, 2), (2, 1, 0), (3, 1, 2), (4, 2, 0), (5, 2, 1)]
)
def test_misalignment_entries_are_xy_xz_yx_yz_zx_zy(entry, output, source):
    truth = moving()
    x = truth.sensor("imu1").gyro
    got = read(truth, imu(ChannelProfile(misalignment=0.02 * np.eye(6)[entry]))).gyro
    expected = x.copy()
    expected[:, output] += 0.02 * x[:, source]  # entry ij multiplies input j
    assert np.allclose(got, expected, rtol=0, atol=1e-15)  # rounding only


def test_g_sensitivity_leaks_the_true_specific_force_into_the_gyro():
    truth = moving()
    matrix = np.array([[1e-3, 2e-3, 0], [0, -1e-3, 4e-3], [5e-3, 0, 0]])
    got = read(truth, imu(accel=ChannelProfile(scale=[0.5, 0.5, 0.5]), g_sensitivity=matrix))
    s = truth.sensor("imu1")
    expected = s.gyro + np.stack([matrix @ f for f in s.specific_force])
    assert np.allclose(got.gyro, expected, rtol=0, atol=1e-14)  # rounding only


def test_errors_act_in_parallel_on_the_true_signal():
    truth = moving(seconds=0.2)
    scale, skew, bias = np.array([0.1, 0.2, -0.1]), np.array([0.01, 0.02, 0.03, 0.04, 0.05, 0.06]), np.array([1, 2, 3])
    leak = 1e-3 * np.arange(9.0).reshape(3, 3)
    got = read(truth, imu(ChannelProfile(scale=scale, misalignment=skew, bias=bias), g_sensitivity=leak))
    m = np.array([[0, 0.01, 0.02], [0.03, 0, 0.04], [0.05, 0.06, 0]])
    s = truth.sensor("imu1")
    for y, x, f in zip(got.gyro, s.gyro, s.specific_force, strict=True):
        assert np.allclose(y, x + m @ x + scale * x + leak @ f + bias, rtol=0, atol=1e-14)  # rounding only


@pytest.mark.parametrize("cutoff", [5.0, 40.0])
def test_low_pass_is_first_order_and_causal(cutoff):
    time = np.arange(3001) / DENSE
    start = 1.0
    ramp = np.maximum(time - start, 0)[:, None] * np.ones(3)
    got = observe_imu(sensor_truth(ramp, ramp), time, imu(ChannelProfile(bandwidth=cutoff)), np.random.default_rng(0))
    lag = 1 / (2 * np.pi * cutoff)
    since = np.maximum(time - start, 0)
    expected = since - lag * (1 - np.exp(-since / lag))  # response of 1/(lag s + 1) to a ramp
    assert np.allclose(got.gyro, expected[:, None], rtol=0, atol=1e-12)  # exact for piecewise linear input
    assert np.array_equal(got.accel, ramp)  # the other channel is not filtered
    assert not got.gyro[time < start].any()  # nothing before its cause


def test_low_pass_of_a_tone_has_the_gain_and_lag_of_first_order():
    time = np.arange(4001) / DENSE
    tone = np.sin(2 * np.pi * 6 * time)[:, None] * np.ones(3)
    sensor = sensor_truth(tone, tone)
    got = observe_imu(sensor, time, imu(accel=ChannelProfile(bandwidth=8.0)), np.random.default_rng(0)).accel
    expected = np.sin(2 * np.pi * 6 * time - np.arctan(6 / 8)) / np.hypot(1, 6 / 8)
    settled = time > 1.0  # exp(-2 pi 8) of the start is left
    # linear interpolation between dense samples loses (2 pi 6 / 1000)^2 / 12 = 1.2e-4 of a 6 Hz tone
    assert np.allclose(got[settled], expected[settled, None], rtol=0, atol=1.5e-4)


def test_low_pass_starts_settled():
    time = np.arange(100) / DENSE
    level = np.tile([1.0, -2.0, 9.81], (100, 1))
    got = observe_imu(sensor_truth(level, level), time, imu(ChannelProfile(bandwidth=3.0)), np.random.default_rng(0))
    assert np.allclose(got.gyro, level, rtol=1e-13)  # rounding only


def test_quantisation_rounds_to_the_nearest_multiple():
    truth = moving()
    got = read(truth, imu(ChannelProfile(step=0.05))).gyro
    x = truth.sensor("imu1").gyro
    assert np.allclose(got / 0.05, np.round(got / 0.05), rtol=0, atol=1e-9)  # rounding of n * 0.05
    assert np.abs(got - x).max() <= 0.025 + 1e-12
    assert (got - x).std() == pytest.approx(0.05 / np.sqrt(12), rel=0.05)  # a slow sweep is not quite uniform


def test_readings_are_clipped_at_the_range_after_rounding():
    truth = moving()
    got = read(truth, imu(ChannelProfile(range=2.0), ChannelProfile(range=9.9, step=0.4)))
    s = truth.sensor("imu1")
    assert np.array_equal(got.gyro, np.clip(s.gyro, -2.0, 2.0))
    assert np.abs(got.accel).max() == 9.9  # 10.0, the next multiple of the step, never shows
    inside = np.abs(s.specific_force) < 9.5
    assert np.abs(got.accel - s.specific_force)[inside].max() <= 0.2 + 1e-12


# --- drop-outs ---------------------------------------------------------------------------------------------


def test_missing_samples_are_gone_and_the_others_untouched():
    truth = moving()
    whole, holed = read(truth, imu()), read(truth, imu(dropout_fraction=0.2))
    rows = np.searchsorted(whole.time, holed.time)
    assert np.array_equal(whole.time[rows], holed.time)
    assert np.array_equal(whole.gyro[rows], holed.gyro)
    assert np.array_equal(whole.accel[rows], holed.accel)
    assert rows[0] == 0
    # binomial: sqrt(0.2 * 0.8 / 4001) = 0.0063
    assert 1 - len(rows) / len(whole.time) == pytest.approx(0.2, abs=0.026)


def test_held_samples_repeat_the_last_good_one():
    truth = moving()
    whole, held = read(truth, imu()), read(truth, imu(dropout_fraction=0.2, dropout_mode="held"))
    missing = read(truth, imu(dropout_fraction=0.2))
    assert np.array_equal(held.time, whole.time)
    last_good = np.searchsorted(missing.time, whole.time, side="right") - 1  # the same draws in both modes
    assert np.array_equal(held.gyro, missing.gyro[last_good])
    assert np.array_equal(held.accel, missing.accel[last_good])
    assert (held.gyro[1:] == held.gyro[:-1]).all(axis=1).mean() == pytest.approx(0.2, abs=0.026)  # as above


@pytest.mark.parametrize("mode", ["missing", "held"])
def test_the_first_sample_is_never_lost(mode):
    truth = moving(seconds=0.05)
    for seed in range(20):  # at 95 % losses a first sample left to chance would be there in one run of 20
        got = read(truth, imu(dropout_fraction=0.95, dropout_mode=mode), seed)
        assert got.time[0] == truth.time[0]
        assert np.array_equal(got.gyro[0], truth.sensor("imu1").gyro[0])
