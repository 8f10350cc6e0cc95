"""Sequences of motions as recordings: pieces of one session, put together on one clock.

    sequence = assemble("sequence2", seed=1)
    sequence.recording, sequence.sections, sequence.axes

The method under test knows no dynamics, so samples may be shuffled (Olsson 2020, section 7.1).
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from imubench.arrays import Array
from imubench.errors import InputError
from imubench.recording import Imu, Recording, positive
from imubench.scenarios.olsson2020.plan import Plan, find
from imubench.scenarios.olsson2020.session import Alter, Session, record, rows_between
from imubench.sim.imu_profile import ImuProfile
from imubench.sim.rigs import Rig


@dataclass(frozen=True)
class Section:
    """A piece of a motion within a sequence."""

    motion: int
    start: float  # s, sequence
    end: float  # s
    cut_start: float  # s, where the piece begins within its motion


@dataclass(frozen=True)
class Sequence:
    """A recording made of pieces, with their boundaries, and the truth about the axes."""

    name: str
    seed: int
    recording: Recording
    sections: tuple[Section, ...]
    axes: Array  # (2, 3) the true hinge axis in the axes of imu1 and imu2

    @property
    def duration(self) -> float:
        """The end of the last section, s."""
        return self.sections[-1].end


def assemble(
    which: str | Path | Plan,
    seed: int = 0,
    rig: Rig | None = None,
    imus: ImuProfile | Mapping[str, ImuProfile] | None = None,
    remove_gyro_bias: bool = True,
    durations: Mapping[int, float] | None = None,
    alter: Alter | None = None,
) -> Sequence:
    """Return a sequence by name, path or plan, from a new session; the other arguments are those of `record`.

    Raises `InputError` as `find`, `record` and `join` do. To make several sequences of one session, as the
    paper does, call `record` once and `join` for each.
    """
    plan = which if isinstance(which, Plan) else find(which)
    return join(plan, record(seed, rig, imus, remove_gyro_bias, durations, alter))


def join(plan: Plan, session: Session) -> Sequence:
    """Return the sequence that a plan makes of a session; cuts are rounded to whole samples.

    Raises `InputError` for a cut that reaches beyond its motion or holds no sample.
    """
    rate = max(imu.rate for imu in session.recording.imus)
    sections: list[Section] = []
    starts: list[float] = []  # in the session
    for i, piece in enumerate(plan.pieces):
        where = f"{plan.name}.pieces[{i}]"
        first, last = session.span(piece.motion)
        begin, end = (round(x * rate) / rate for x in piece.cut(last - first, where))
        if not end > begin:
            raise InputError(f"{where}: expected a cut of at least one sample of {1 / rate:g} s, got {piece.seconds}")
        for _ in range(piece.repeat):
            now = sections[-1].end if sections else 0.0
            sections.append(Section(piece.motion, now, round((now + end - begin) * rate) / rate, begin))
            starts.append(first + begin)
    imus = tuple(_pieced(imu, sections, starts) for imu in session.recording.imus)
    recording = replace(session.recording, name=f"{plan.name}-{session.seed}", imus=imus)
    return Sequence(plan.name, session.seed, recording, tuple(sections), session.axes)


def _pieced(imu: Imu, sections: list[Section], starts: list[float]) -> Imu:
    """Return one IMU's samples of each section, stamped on the clock of the sequence."""
    lengths = [section.end - section.start for section in sections]
    pieces = [rows_between(imu, start, start + length) for start, length in zip(starts, lengths, strict=True)]
    stamps = [p.time + (s.start - start) for p, s, start in zip(pieces, sections, starts, strict=True)]
    return replace(
        imu,
        time=np.concatenate(stamps),
        gyro=np.concatenate([p.gyro for p in pieces]),
        accel=np.concatenate([p.accel for p in pieces]),
    )


def add_bias(recording: Recording, rng: np.random.Generator, gyro: float, accel: float) -> Recording:
    """Return the recording with biases of these magnitudes (rad/s, m/s^2) in directions drawn for every sensor.

    Source: Olsson 2020, section 7.5, with 1 deg/s and 1 m/s^2.
    """
    positive(gyro, "gyro bias", or_zero=True)
    positive(accel, "accel bias", or_zero=True)
    imus = []
    for imu in recording.imus:
        directions = rng.normal(size=(2, 3))
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        imus.append(replace(imu, gyro=imu.gyro + gyro * directions[0], accel=imu.accel + accel * directions[1]))
    return replace(recording, imus=tuple(imus))
