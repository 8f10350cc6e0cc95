"""A drawn recording is played: its samples as IMUs take them, and the truth on the grid of the recording's rate."""

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from imubench.arrays import Array
from imubench.dataset.drawing import Drawn, draw
from imubench.dataset.imu_choices import on_the_truths_grid
from imubench.dataset.motion_ranges import BEYOND
from imubench.dataset.ranges import located
from imubench.dataset.spec import Spec
from imubench.dataset.swing_range import FreeSwing
from imubench.recording import Imu, Recording
from imubench.sim.imu_model import Declared, observe
from imubench.sim.injected import injected_samples
from imubench.sim.play import play
from imubench.truth import Truth

OVERSAMPLING = 10  # of the truth, for IMUs with a filter or a clock of their own
SNAP = 1e-6  # of a sample: a stamp this close below the middle between two rows belongs to the later one


@dataclass(frozen=True)
class Made:
    """One recording of a dataset, its truth, and what was drawn for it."""

    recording: Recording
    truth: Truth  # every 1 / rate s, from 0 to the end
    drawn: Drawn


def make(spec: Spec, seed: int, index: int) -> Made:
    """Return recording `index` of a spec and a seed, the same to the bit wherever it is made."""
    drawn = draw(spec, seed, index)
    grid = all(on_the_truths_grid(part) for part in drawn.parts.values())
    split = 1 if grid else OVERSAMPLING
    free, seconds = isinstance(drawn.motion, FreeSwing), drawn.seconds + (0 if grid else BEYOND)
    with located(f"recording {index} of seed {seed}"):
        if isinstance(drawn.motion, FreeSwing):
            world = drawn.motion.play(drawn.rig, seconds, spec.rate * split)
        else:
            world = play(drawn.rig, drawn.motion, seconds, spec.rate * split, threads=1)
    declared = Declared(
        mounts=drawn.declared,
        motion="free" if free else "hand",
        free_swings=((0.0, drawn.seconds),) if free else (),
        body=drawn.body,
        gravity=drawn.declared_gravity,
        base=drawn.rig.base,
        base_quaternion=drawn.rig.base_quaternion,
    )
    name = f"{spec.name}-{index:07d}"
    observed = observe(world, drawn.parts, drawn.streams["observing"], name, declared)
    imus = zip(observed.imus, drawn.streams["samples"].spawn(len(observed.imus)), strict=True)
    told = tuple(_told(imu, drawn, rng) for imu, rng in imus)
    count = round(drawn.seconds * spec.rate)
    truth = thinned(world, split, count)
    return Made(replace(observed, imus=told, **_read(drawn, truth)), truth, drawn)


def _read(drawn: Drawn, truth: Truth) -> dict[str, Any]:
    """Return what a recording's encoder and its measured poses say."""
    first, *others = drawn.streams["instruments"].spawn(1 + len(drawn.poses))
    encoder, poses = drawn.encoder, zip(drawn.poses, others, strict=True)
    return {
        "encoders": () if encoder is None else (encoder.read(truth, drawn.effects, first),),
        "poses": tuple(pose.read(truth, own) for pose, own in poses),
    }


def _told(imu: Imu, drawn: Drawn, rng: np.random.Generator) -> Imu:
    """Return an IMU's samples within the recording, all effects in them, and what its owner believes about it."""
    rows = rows_of(imu.time, imu.rate)
    kept = (rows >= 0) & (rows < round(drawn.seconds * imu.rate))
    if not kept.all():
        imu = replace(imu, time=imu.time[kept], gyro=imu.gyro[kept], accel=imu.accel[kept])
    nominal = drawn.nominal[imu.name]
    return replace(
        injected_samples(imu, drawn.effects, rng),
        gyro_noise_std=nominal.gyro.declared_noise_std(imu.rate),
        accel_noise_std=nominal.accel.declared_noise_std(imu.rate),
        gyro_range=nominal.gyro.range,
        accel_range=nominal.accel.range,
    )


def thinned(truth: Truth, every: int, count: int) -> Truth:
    """Return the first `count` of every so many samples of a truth."""
    rows = slice(0, every * count, every)

    def cut(part: Any) -> Any:
        arrays = {f.name: getattr(part, f.name)[rows] for f in fields(part) if _is_series(getattr(part, f.name))}
        return replace(part, **arrays)

    return replace(
        cut(truth),
        segments=tuple(cut(segment) for segment in truth.segments),
        sensors=tuple(cut(sensor) for sensor in truth.sensors),
    )


def rows_of(stamps: Array, rate: float) -> NDArray[np.intp]:
    """Return the row nearest to each stamp (n,) s; those one period apart get neighbouring rows, rounding or not."""
    first = int(np.floor(stamps[0] * rate + 0.5 + SNAP))
    return first + np.rint((stamps - stamps[0]) * rate).astype(np.intp)


def _is_series(value: object) -> bool:
    return isinstance(value, np.ndarray)
