"""Each error source of the IMU model alone, against its own equation; then all of them together."""

from dataclasses import replace

import numpy as np
import pytest

from imubench.errors import InputError
from imubench.recording import Body, Encoder
from imubench.sim.imu_model import Declared, DeclaredMount, observe, observe_imu
from imubench.sim.imu_profile import ChannelProfile, ImuProfile
from imubench.truth import SensorTruth, Truth

DENSE = 1000.0  # Hz
TONES = np.array([0.7, 1.9, 3.1])  # Hz, one an axis


def motion(time):
    """Return smooth gyro (rad/s) and specific force (m/s^2) at any times."""
    phase = 2 * np.pi * TONES * np.asarray(time)[:, None] + np.array([0.1, 1.2, 2.3])
    return 3.0 * np.sin(phase), 4.0 * np.cos(1.3 * phase) + np.array([0.0, 0.0, 9.81])


def sensor_truth(gyro, force, name="imu1"):
    zero, still = np.zeros_like(gyro), np.tile([1.0, 0, 0, 0], (len(gyro), 1))
    return SensorTruth(name, zero, still, zero, gyro, force, zero, zero, None, zero, zero)


def moving(seconds=4.0, dense=DENSE, start=0.0, names=("imu1", "imu2")):
    time = start + np.arange(round(seconds * dense) + 1) / dense
    gyro, force = motion(time)
    sensors = tuple(sensor_truth((k + 1) * gyro, force, name) for k, name in enumerate(names))
    return Truth(time, "hinge", 9.81, (), sensors)


def still(count, rate=100.0):
    """Return time and a sensor that reads nothing, at the IMU's own rate: what comes out is error."""
    return np.arange(count) / rate, sensor_truth(np.zeros((count, 3)), np.zeros((count, 3)))


def imu(gyro=None, accel=None, rate=DENSE, **sampling):
    return ImuProfile("test", rate, gyro or ChannelProfile(), accel or ChannelProfile(), **sampling)


def read(truth, profile, seed=0):
    return observe_imu(truth.sensor("imu1"), truth.time, profile, np.random.default_rng(seed))


def errors(channel, count, seed=0, rate=100.0):
    """Return the gyro of a still sensor (count, 3): its additive errors alone."""
    time, sensor = still(count, rate)
    return observe_imu(sensor, time, imu(channel, rate=rate), np.random.default_rng(seed)).gyro


def allan_deviation(x, period, tau):
    """Return the non-overlapping Allan deviation of x (n, 3) at tau, axes pooled, and its relative std."""
    m = round(tau / period)
    means = x[: len(x) // m * m].reshape(-1, m, 3).mean(axis=1)
    differences = np.diff(means, axis=0)
    # successive differences share a cluster, so about 2/3 of them count (Lesage and Audoin 1973, white noise)
    return np.sqrt(np.mean(differences**2) / 2), 1 / np.sqrt(2 * (2 / 3) * differences.size)


def periodogram(x, rate, segment):
    """Return frequencies and the one-sided density (u^2/Hz) of x (n, 3), segments and axes averaged."""
    pieces = x[: len(x) // segment * segment].reshape(-1, segment, 3)
    power = np.abs(np.fft.rfft(pieces, axis=1)) ** 2 * 2 / (rate * segment)
    return np.fft.rfftfreq(segment, 1 / rate)[1:-1], power.mean(axis=(0, 2))[1:-1]


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


# --- random errors -----------------------------------------------------------------------------------------


def test_white_noise_has_the_density_and_std_of_its_datasheet():
    density, rate = 2e-3, 100.0
    noise = errors(ChannelProfile(noise_density=density), 200_000)
    assert noise.std() == pytest.approx(density * np.sqrt(rate / 2), rel=0.004)  # 600,000 draws: 0.09 %
    frequency, power = periodogram(noise, rate, 200)
    # 3,000 periodograms a bin: 1.8 % each; 4.5 of these for the worst of 99 bins
    assert np.allclose(power, density**2, rtol=0.082, atol=0)
    assert power.mean() == pytest.approx(density**2, rel=0.008)  # 99 bins: 0.18 %
    assert frequency[0] == 0.5
    assert frequency[-1] == 49.5
    correlation = np.mean(noise[1:] * noise[:-1]) / noise.var()
    assert abs(correlation) < 4 / np.sqrt(600_000)
    axes = np.corrcoef(noise.T) - np.eye(3)
    assert np.abs(axes).max() < 4 / np.sqrt(200_000)


@pytest.mark.parametrize("tau", [0.05, 0.5, 5.0])
def test_allan_deviation_of_white_noise_falls_with_the_root_of_tau(tau):
    density = 2e-3
    got, relative = allan_deviation(errors(ChannelProfile(noise_density=density), 200_000), 0.01, tau)
    assert got == pytest.approx(density / np.sqrt(2 * tau), rel=4 * relative)


def test_noise_behind_a_slow_filter_is_the_filters_own():
    density, rate, cutoff = 2e-3, 200.0, 5.0
    noise = errors(ChannelProfile(noise_density=density, bandwidth=cutoff), 200_000, rate=rate)
    # 1000 s of 2 pi 5 /s correlation: about 30,000 independent values an axis, std known to 0.24 %
    assert noise.std() == pytest.approx(density * np.sqrt(np.pi * cutoff / 2), rel=0.01)
    frequency, power = periodogram(noise - noise.mean(axis=0), rate, 4000)
    below = (frequency > 0.1) & (frequency < 0.5)
    # 8 bins of 150 periodograms: 2.9 %; and the filter has lost 0.4 % there
    assert power[below].mean() == pytest.approx(density**2, rel=0.12)
    at = (frequency > 4.8) & (frequency < 5.2)
    assert power[at].mean() == pytest.approx(density**2 / 2, rel=0.12)  # -3 dB at the cut-off
    lag = np.mean(noise[1:] * noise[:-1]) / noise.var()
    assert lag == pytest.approx(np.exp(-2 * np.pi * cutoff / rate), abs=0.005)


def test_noise_behind_a_wide_filter_folds():
    noise = errors(ChannelProfile(noise_density=2e-3, bandwidth=184.0), 100_000)
    assert noise.std() == pytest.approx(2e-3 * np.sqrt(np.pi * 184 / 2), rel=0.006)  # 300,000 draws: 0.13 %
    assert abs(np.mean(noise[1:] * noise[:-1]) / noise.var()) < 4 / np.sqrt(300_000)


def test_noise_given_per_sample_is_that_noise():
    assert errors(ChannelProfile(noise_std=0.3), 100_000).std() == pytest.approx(0.3, rel=0.006)


def test_bias_is_constant_and_drawn_anew_with_each_seed():
    channel = ChannelProfile(bias=[0.1, -0.2, 0.3], bias_std=0.05)
    runs = np.stack([errors(channel, 5, seed) for seed in range(600)])
    assert (runs == runs[:, :1]).all()
    # 600 draws an axis: mean known to 0.05 / sqrt(600) = 0.002, pooled std to 1.7 %
    assert np.allclose(runs[:, 0].mean(axis=0), [0.1, -0.2, 0.3], rtol=0, atol=0.009)
    assert (runs[:, 0] - [0.1, -0.2, 0.3]).std() == pytest.approx(0.05, rel=0.07)


def test_fixed_bias_is_added_to_each_channel_apart():
    truth = moving()
    got = read(truth, imu(ChannelProfile(bias=[1, 2, 3]), ChannelProfile(bias=[-1, 0, 0])))
    assert np.array_equal(got.gyro, truth.sensor("imu1").gyro + np.array([1, 2, 3]))
    assert np.array_equal(got.accel, truth.sensor("imu1").specific_force + np.array([-1, 0, 0]))


def test_parts_differ_in_scale_and_misalignment():
    truth = moving(seconds=0.02)
    x = truth.sensor("imu1").gyro
    channel = ChannelProfile(scale=[0.1, 0.1, 0.1], scale_std=0.02, misalignment_std=0.01)
    matrices = []
    for seed in range(300):
        y = read(truth, imu(channel), seed).gyro
        matrices.append(np.linalg.lstsq(x, y, rcond=None)[0].T - np.eye(3))
    diagonal = np.stack([np.diag(m) for m in matrices])
    others = np.stack([m[~np.eye(3, dtype=bool)] for m in matrices])
    assert diagonal.mean() == pytest.approx(0.1, abs=4 * 0.02 / 30)  # 900 draws
    assert diagonal.std() == pytest.approx(0.02, rel=0.1)  # 900 draws: 2.4 %
    assert others.std() == pytest.approx(0.01, rel=0.07)  # 1,800 draws: 1.7 %


def test_bias_random_walk_grows_with_the_root_of_time():
    density = 0.01
    runs = np.stack([errors(ChannelProfile(bias_random_walk=density), 401, seed) for seed in range(500)])
    assert not runs[:, 0].any()
    for k in (25, 100, 400):  # 0.25, 1 and 4 s
        # 1,500 walks: std known to 1.8 %
        assert runs[:, k].std() == pytest.approx(density * np.sqrt(k / 100), rel=0.075)


@pytest.mark.parametrize("tau", [0.5, 5.0])
def test_allan_deviation_of_a_random_walk_rises_with_the_root_of_tau(tau):
    density = 0.01
    got, relative = allan_deviation(errors(ChannelProfile(bias_random_walk=density), 300_000), 0.01, tau)
    # m averaged steps add 1 / (2 m^2) to the continuous-time formula, 2e-4 at most here
    assert got == pytest.approx(density * np.sqrt(tau / 3), rel=5 * relative)


@pytest.mark.parametrize("tau", [0.2, 1.9, 20.0])
def test_allan_deviation_of_bias_instability_is_that_of_gauss_markov(tau):
    std, correlation = 0.02, 1.0
    channel = ChannelProfile(bias_instability=std, bias_correlation_time=correlation)
    got, relative = allan_deviation(errors(channel, 400_000), 0.01, tau)
    r = tau / correlation
    variance = 2 * std**2 / r * (1 - (3 - 4 * np.exp(-r) + np.exp(-2 * r)) / (2 * r))  # IEEE Std 952, C.1.5
    assert got == pytest.approx(np.sqrt(variance), rel=5 * relative)


def test_bias_instability_is_stationary_from_the_first_sample():
    channel = ChannelProfile(bias_instability=0.02, bias_correlation_time=1.0)
    runs = np.stack([errors(channel, 301, seed) for seed in range(500)])
    for k in (0, 30, 300):  # 1,500 values: std known to 1.8 %
        assert runs[:, k].std() == pytest.approx(0.02, rel=0.075)
    correlation = np.mean(runs[:, 0] * runs[:, 100]) / np.mean(runs**2)
    assert correlation == pytest.approx(np.exp(-1), abs=0.1)  # 1 / sqrt(1,500) = 0.026


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


# --- randomness --------------------------------------------------------------------------------------------

NOISY = ChannelProfile(
    noise_density=0.01,
    bias_std=0.1,
    bias_random_walk=0.01,
    bias_instability=0.02,
    scale_std=0.01,
    misalignment_std=0.01,
)


def test_one_seed_gives_one_recording_and_another_another():
    truth = moving()
    profile = imu(NOISY, NOISY, rate=100.0, jitter_std=1e-4, dropout_fraction=0.1)
    first, again, other = (observe(truth, profile, np.random.default_rng(seed)) for seed in (5, 5, 6))
    for a, b, c in zip(first.imus, again.imus, other.imus, strict=True):
        assert np.array_equal(a.time, b.time)
        assert np.array_equal(a.gyro, b.gyro)
        assert np.array_equal(a.accel, b.accel)
        assert a.gyro[0, 0] != c.gyro[0, 0]


def test_a_generator_used_twice_gives_two_recordings():
    truth, rng = moving(), np.random.default_rng(5)
    first, second = (observe(truth, imu(NOISY), rng) for _ in range(2))
    assert not np.array_equal(first.imus[0].gyro, second.imus[0].gyro)


ALONE = {
    "noise": {"noise_density": 0.01},
    "bias": {"bias_std": 0.1},
    "random walk": {"bias_random_walk": 0.01},
    "instability": {"bias_instability": 0.02},
}


@pytest.mark.parametrize("left_out", ALONE)
def test_an_error_more_leaves_the_draws_of_the_others_alone(left_out):
    def all_but(*names):
        return {k: v for name, entry in ALONE.items() if name not in names for k, v in entry.items()}

    everything = errors(ChannelProfile(**all_but()), 500)
    without = errors(ChannelProfile(**all_but(left_out)), 500)
    alone = errors(ChannelProfile(**ALONE[left_out]), 500)
    assert np.allclose(everything, without + alone, rtol=0, atol=1e-15)  # rounding only
    assert alone.any()


def test_the_channels_and_the_sensors_draw_apart():
    truth = moving(names=("imu1", "imu2"))
    noisy, quiet = imu(NOISY, NOISY), imu()
    both = observe(truth, noisy, np.random.default_rng(3))
    only_first = observe(truth, {"imu1": noisy, "imu2": quiet}, np.random.default_rng(3))
    just_second = observe(truth, {"imu2": noisy}, np.random.default_rng(3))
    no_gyro = observe(truth, imu(accel=NOISY), np.random.default_rng(3))
    assert np.array_equal(both.imu("imu1").gyro, only_first.imu("imu1").gyro)
    assert np.array_equal(both.imu("imu2").gyro, just_second.imu("imu2").gyro)
    assert np.array_equal(both.imu("imu1").accel, no_gyro.imu("imu1").accel)
    noise = errors(ChannelProfile(noise_std=1.0), 50_000)
    time, sensor = still(50_000)
    pair = observe_imu(
        sensor, time, imu(ChannelProfile(noise_std=1.0), ChannelProfile(noise_std=1.0), 100.0), np.random.default_rng(0)
    )
    assert np.array_equal(pair.gyro, noise)
    assert abs(np.mean(pair.gyro * pair.accel)) < 4 / np.sqrt(150_000)  # independent, not shared


def test_drop_outs_and_jitter_leave_the_noise_alone():
    channel = ChannelProfile(noise_std=0.1)
    time, sensor = still(1000)
    plain, holed = (
        observe_imu(sensor, time, imu(channel, rate=100.0, **extra), np.random.default_rng(2))
        for extra in ({}, {"dropout_fraction": 0.3, "jitter_std": 1e-3})
    )
    rows = np.searchsorted(plain.time, holed.time)
    assert np.array_equal(plain.gyro[rows], holed.gyro)


# --- declared facts, and bad input -------------------------------------------------------------------------


def test_the_recording_declares_what_the_profile_and_the_caller_say():
    mount = DeclaredMount([0.1, 0, 0.02], [0, 1, 0, 0], 0.005, 0.02)
    body = Body(1.2, [0, 0, -0.25], [0.03, 0.03, 0.002])
    encoder = Encoder("hinge", np.arange(5.0), np.zeros(5), 1e-3)
    facts = Declared(
        {"imu2": mount}, motion="free", base="fixed", base_quaternion=[0, 0, 0, 1],
        encoders=(encoder,), free_swings=((1.0, 2.0),), body=body,
    )  # fmt: skip
    profile = imu(ChannelProfile(noise_density=0.01, range=30.0), ChannelProfile(noise_std=0.2, step=0.3), 100.0)
    got = observe(moving(), profile, np.random.default_rng(0), "swing", facts)
    assert (got.name, got.rig, got.motion, got.base, got.gravity) == ("swing", "hinge", "free", "fixed", 9.81)
    assert got.encoders == (encoder,)
    assert got.free_swings == ((1.0, 2.0),)
    assert got.body is body
    assert got.base_quaternion.tolist() == [0, 0, 0, 1]
    first, second = got.imus
    assert first.mount_position_std is None
    assert second.mount_position.tolist() == [0.1, 0, 0.02]
    assert second.mount_quaternion.tolist() == [0, 1, 0, 0]
    assert (second.mount_position_std, second.mount_rotation_std) == (0.005, 0.02)
    assert (second.rate, second.gyro_range, second.accel_range) == (100.0, 30.0, None)
    assert second.gyro_noise_std == pytest.approx(0.01 * np.sqrt(50), rel=1e-12)
    assert second.accel_noise_std == pytest.approx(np.sqrt(0.2**2 + 0.3**2 / 12), rel=1e-12)


def test_the_declared_noise_is_what_a_laboratory_would_measure():
    channel = ChannelProfile(noise_density=0.01, bandwidth=92.0, step=0.1, bias=[0.013, 0.04, 0.07])
    time, sensor = still(100_000)
    got = observe_imu(sensor, time, imu(channel, rate=100.0), np.random.default_rng(0))
    # 300,000 samples: 0.13 %; rounding adds step^2 / 12 only on average over where the level lies
    assert got.gyro.std(axis=0).mean() == pytest.approx(got.gyro_noise_std, rel=0.01)


def test_a_declared_gravity_need_not_be_true():
    assert observe(moving(), imu(), np.random.default_rng(0), declared=Declared(gravity=9.7)).gravity == 9.7


@pytest.mark.parametrize(
    ("profiles", "declared"), [({"imu3": imu()}, Declared()), (imu(), Declared({"imu3": DeclaredMount()}))]
)
def test_an_unknown_sensor_is_named_with_the_known_ones(profiles, declared):
    with pytest.raises(InputError, match=r"^unknown sensor 'imu3'; known: imu1, imu2$"):
        observe(moving(), profiles, np.random.default_rng(0), declared=declared)


def test_an_uneven_truth_is_refused():
    truth = moving(seconds=0.1)
    time = truth.time.copy()
    time[50:] += 2e-4
    with pytest.raises(InputError, match=r"^truth\.time: expected evenly spaced samples, got 0\.0012 s in row 50$"):
        read(replace(truth, time=time), imu())


def test_a_truth_too_short_to_interpolate_is_refused():
    truth = moving(seconds=0.002)
    with pytest.raises(InputError, match="expected at least 4 samples to interpolate between, got 3"):
        read(truth, imu(rate=700.0))
    with pytest.raises(InputError, match="expected at least 2 samples, got 1"):
        read(moving(seconds=0.0), imu())


@pytest.mark.parametrize(
    ("numbers", "message"),
    [
        ({"noise_density": -1.0}, "noise_density: expected a number >= 0, got -1.0"),
        ({"noise_density": 1.0, "noise_std": 1.0}, "noise: expected noise_density or noise_std, got both"),
        ({"bias": [1.0, 2.0]}, r"bias: expected shape \(3\), got \(2,\)"),
        ({"misalignment": np.zeros(3)}, r"misalignment: expected shape \(6\), got \(3,\)"),
        ({"range": 0.0}, "range: expected a number > 0, got 0.0"),
        ({"bandwidth": np.nan}, "bandwidth: expected a number > 0, got nan"),
    ],
)
def test_a_channel_refuses_what_cannot_be(numbers, message):
    with pytest.raises(InputError, match=f"^{message}$"):
        ChannelProfile(**numbers)


@pytest.mark.parametrize(
    ("numbers", "message"),
    [
        ({"rate": 0.0}, r"profile test\.rate: expected a number > 0, got 0\.0"),
        ({"dropout_fraction": 1.0}, r"profile test\.dropout_fraction: expected a fraction below 1, got 1"),
        ({"dropout_mode": "lost"}, "unknown dropout_mode 'lost'; known: missing, held"),
        ({"clock_skew": 0.7}, r"profile test\.clock_skew: expected a number between -0\.5 and 0\.5, got 0\.7"),
        ({"clock_offset": np.inf}, r"profile test\.clock_offset: expected a finite number of seconds, got inf"),
        ({"g_sensitivity": np.zeros(3)}, r"profile test\.g_sensitivity: expected shape \(3, 3\), got \(3,\)"),
    ],
)
def test_a_profile_refuses_what_cannot_be(numbers, message):
    with pytest.raises(InputError, match=f"^{message}$"):
        imu(**numbers)
