"""The files of a hinge's two IMUs in each other's place."""

from collections.abc import Iterator
from dataclasses import replace

from imubench.diagnosis.config.nonsense import AXIS_ORDER
from imubench.diagnosis.nonsense.rough_fit import mounts_known, rough_misfit
from imubench.diagnosis.nonsense.stretch import dense_enough
from imubench.diagnosis.result import Nonsense
from imubench.recording import Imu, Recording


def swapped(recording: Recording) -> Iterator[Nonsense]:
    """Yield that the two IMUs look swapped, where the declared mounts tell: both orders are fitted to the rig."""
    if recording.tree.hinge is None or len(recording.imus) != 2 or not mounts_known(recording):
        return
    one, two = recording.imus
    if not (dense_enough(one.time) and dense_enough(two.time)):
        return
    alone = replace(recording, encoders=(), poses=(), free_swings=(), body=None, motion="hand")
    if (declared := rough_misfit(alone)) < AXIS_ORDER.odd_misfit:
        return
    other = rough_misfit(replace(alone, imus=(reading(one, two), reading(two, one))))
    if declared > AXIS_ORDER.worse * other:
        evidence = {"misfit": min(declared, 1e6), "misfit_swapped": other}
        what = "imu1 and imu2 look swapped: their files go with each other's mounts"
        yield Nonsense("joint", what, evidence, advice="check which file is of which IMU")


def reading(imu: Imu, other: Imu) -> Imu:
    """Return an IMU, on its mount, with what another one reads."""
    return replace(imu, time=other.time, gyro=other.gyro, accel=other.accel, rate=other.rate)


__all__ = ["swapped"]
