"""Each random error of the IMU model against its statistics, and that each draws apart."""

import numpy as np
import pytest

from imubench.sim.imu_model import observe, observe_imu
from imubench.sim.imu_profile import ChannelProfile
from tests.imu_signals import errors, imu, moving, read, still


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
