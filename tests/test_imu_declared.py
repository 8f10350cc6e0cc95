"""What a simulated recording declares, and what the IMU model refuses."""

from dataclasses import replace

import numpy as np
import pytest

from imubench.errors import InputError
from imubench.recording import Body, Encoder
from imubench.sim.imu_model import Declared, DeclaredMount, observe, observe_imu
from imubench.sim.imu_profile import ChannelProfile
from tests.imu_signals import imu, moving, read, still


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
    with pytest.raises(InputError, match=r"^unknown sensor 'imu3'; known: imu1, imu2; did you mean 'imu2'\?$"):
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
