"""The noise of an IMU that a recording names by a profile of `sim/profiles.toml`."""

from collections.abc import Mapping

from imubench.recording import Imu
from imubench.sim.profiles import profile

PARTS = ("gyro", "accel")


def profile_noise(name: str, rate: float) -> dict[str, float]:
    """Return the noise std per sample of an IMU at a rate, rounding included.

    Args:
        name: of a profile.
        rate: Hz, of the recording, which may differ from the profile's own.

    Returns:
        `gyro_noise_std` in rad/s and `accel_noise_std` in m/s^2; without those that the profile has none of.

    Raises:
        InputError: for an unknown profile.
    """
    named = profile(name)
    levels = {f"{part}_noise_std": getattr(named, part).declared_noise_std(rate) for part in PARTS}
    return {key: std for key, std in levels.items() if std > 0}


def by_profile(imu: Imu) -> Mapping[str, float]:
    """Return those noise stds of an IMU that are its profile's, by their names; empty where it names none."""
    told = profile_noise(imu.profile, imu.rate) if imu.profile else {}
    return {key: std for key, std in told.items() if getattr(imu, key) == std}


__all__ = ["by_profile", "profile_noise"]
