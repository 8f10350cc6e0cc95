"""IMUs of a dataset: profiles of the project or of a file of one's own, and the one part that was bought.

A profile says how parts differ (`bias_std`, `scale_std`, `misalignment_std`). A recording has one part, whose numbers
are drawn here, so that they stand in the table of recordings and not only in the samples.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from imubench.dataset.motion_ranges import Files
from imubench.dataset.ranges import check_keys, weight
from imubench.errors import InputError, unknown
from imubench.sim.imu_noise import linear_errors
from imubench.sim.imu_profile import ChannelProfile, ImuProfile
from imubench.sim.profiles import PROFILES, parse_profiles


@dataclass(frozen=True)
class ImuChoice:
    """One `[[imu]]` of a spec."""

    profile: ImuProfile
    weight: float


def parse_imu(table: Mapping[str, Any], where: str, files: Files) -> ImuChoice:
    """Return one `[[imu]]`; `InputError` for an unknown profile or a file that holds none."""
    check_keys(table, ("profile", "file", "weight"), where)
    known = PROFILES
    path = table.get("file")
    if path is not None:
        if not isinstance(path, str):
            raise InputError(f"{where}.file: expected a path beside the spec, got {path!r}")
        known = parse_profiles(files(path, f"{where}.file"), path)
    name = table.get("profile")
    if not isinstance(name, str) or name not in known:
        raise unknown(f"{where}.profile", name, known)
    return ImuChoice(known[str(name)], weight(table, where))


def bought(profile: ImuProfile, rate: float, rng: np.random.Generator) -> ImuProfile:
    """Return one part of a profile at `rate` Hz: bias, scale and misalignment drawn, noise as a std per sample."""
    gyro, accel = rng.spawn(2)
    return replace(
        profile,
        rate=rate,
        gyro=_channel(profile.gyro, "gyro", rate, gyro),
        accel=_channel(profile.accel, "accel", rate, accel),
    )


def _channel(channel: ChannelProfile, kind: str, rate: float, rng: np.random.Generator) -> ChannelProfile:
    draws = dict(zip((f"{kind}.scale", f"{kind}.misalignment"), rng.spawn(2), strict=True))
    matrix = linear_errors(channel, kind, draws)
    return replace(
        channel,
        noise_density=0.0,
        noise_std=channel.sample_noise_std(rate),
        bias=channel.bias + channel.bias_std * rng.standard_normal(3),
        bias_std=0.0,
        scale=np.diag(matrix),
        scale_std=0.0,
        misalignment=matrix[~np.eye(3, dtype=bool)],
        misalignment_std=0.0,
    )


def on_the_truths_grid(profile: ImuProfile) -> bool:
    """Return whether an IMU samples the truth as it is: no filter, no clock of its own, no jitter."""
    own_clock = profile.jitter_std or profile.clock_offset or profile.clock_skew
    return not own_clock and profile.gyro.bandwidth is None and profile.accel.bandwidth is None
