"""Motions that a dataset draws from: random ones, the 14 of Olsson et al., the pendulum's, a file of one's own, swings.

A new kind is one class with `parse`, `suits` and `draw`, and one line in `KINDS`.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

import numpy as np

from imubench.dataset.motion_file import MotionFile
from imubench.dataset.ranges import Range, check_keys, parse_range, weight
from imubench.dataset.rig_ranges import RigRange
from imubench.dataset.swing_range import FreeSwing, SwingMotion
from imubench.errors import InputError, unknown
from imubench.scenarios.olsson2020.motions import MARGIN, MOTIONS, SHORTEST
from imubench.sim.motion import AngleMotion, Later, Motion
from imubench.sim.signals import Signal, Sines, hand

Files = Callable[[str, str], bytes]
"""Takes a path as the spec has it and where it stands there; returns the file's content."""


class MotionRange(Protocol):
    """One `[[motion]]` of a spec."""

    kind: ClassVar[str]

    @property
    def weight(self) -> float:
        """How often it comes, beside the others."""

    def suits(self, rig: RigRange) -> bool:
        """Return whether a rig can do it."""

    def draw(self, rng: np.random.Generator, seconds: float) -> tuple[str, Motion | FreeSwing]:
        """Return a motion that is defined up to `seconds` s, or how a swing begins, and its name."""


def parse_motion(table: Mapping[str, Any], where: str, files: Files, seconds: Range) -> MotionRange:
    """Return one `[[motion]]`; `InputError` says what is wrong with it."""
    kind = table.get("kind")
    if not isinstance(kind, str) or kind not in KINDS:
        raise unknown(f"{where}.kind", kind, KINDS)
    return KINDS[kind](table, where, files, seconds)


@dataclass(frozen=True)
class RandomMotion:
    """A hand's: every angle and coordinate smooth, band-limited and random."""

    kind: ClassVar[str] = "random"
    weight: float
    ranges: Mapping[str, Range]
    DEFAULTS: ClassVar[Mapping[str, object]] = {
        "bandwidth": [0.5, 2.0],  # Hz
        "turn": [0.3, 1.0],  # rad, std of heading and spin; tilt has half of it
        "angle": [0.3, 0.9],  # rad, std of the hinge angle
        "angle_mean": [-0.3, 0.9],  # rad
        "shift": [0.02, 0.12],  # m, std of the origin's path along x, y and z
    }

    @classmethod
    def parse(cls, table: Mapping[str, Any], where: str, files: Files, seconds: Range) -> "RandomMotion":
        """Return the motion of a table."""
        check_keys(table, ("kind", "weight", *cls.DEFAULTS), where)
        low = {"bandwidth": 0.01, "angle_mean": -np.inf}
        ranges = {
            key: parse_range(table.get(key, default), f"{where}.{key}", low.get(key, 0.0))
            for key, default in cls.DEFAULTS.items()
        }
        parse_range(table.get("bandwidth", 1.0), f"{where}.bandwidth", high=20.0)
        return cls(weight(table, where), ranges)

    def suits(self, rig: RigRange) -> bool:
        """Return True: every rig can."""
        return True

    def draw(self, rng: np.random.Generator, seconds: float) -> tuple[str, Motion]:
        """Return a motion; the parts that a rig does not have mean nothing to it."""
        r = {key: found.one(rng) for key, found in self.ranges.items()}

        def signal(std: float, offset: float = 0.0) -> Signal:
            return hand(rng, seconds, std, r["bandwidth"], offset)

        return self.kind, AngleMotion(
            heading=signal(r["turn"]), tilt=signal(r["turn"] / 2), spin=signal(r["turn"]),
            angle=signal(r["angle"], r["angle_mean"]),
            x=signal(r["shift"]), y=signal(r["shift"]), z=signal(r["shift"], 1.0),
        )  # fmt: skip


@dataclass(frozen=True)
class OlssonMotions:
    """The 14 motions of Olsson et al. 2020, on a hinge whose base is free."""

    kind: ClassVar[str] = "olsson2020"
    weight: float
    numbers: tuple[int, ...]

    @classmethod
    def parse(cls, table: Mapping[str, Any], where: str, files: Files, seconds: Range) -> "OlssonMotions":
        """Return the motions of a table."""
        check_keys(table, ("kind", "weight", "numbers"), where)
        numbers = table.get("numbers", list(MOTIONS))
        if not isinstance(numbers, list) or not numbers:
            raise InputError(f"{where}.numbers: expected a list of motions, got {numbers!r}")
        for n in numbers:
            if n not in MOTIONS or isinstance(n, bool | float):
                raise unknown(f"motion in {where}.numbers", n, MOTIONS)
        if seconds.low < SHORTEST:
            raise InputError(f"seconds: expected {SHORTEST:g} s or more for {cls.kind} motions, got {seconds.low:g} s")
        return cls(weight(table, where), tuple(numbers))

    def suits(self, rig: RigRange) -> bool:
        """Return whether a rig is a hinge in a hand."""
        return rig.tree.hinge is not None and rig.base == "free"

    def draw(self, rng: np.random.Generator, seconds: float) -> tuple[str, Motion]:
        """Return one of the motions, its lead-in left out."""
        n = int(rng.choice(self.numbers))
        return f"{self.kind}-{n}", Later(MOTIONS[n].motion(rng, seconds), MARGIN)


@dataclass(frozen=True)
class PendulumMotion:
    """A limb that circles about its pivot, more or less wide and fast (Garcia de Villa et al., section IV-A)."""

    kind: ClassVar[str] = "pendulum"
    weight: float
    amplitude: Range  # of the paper's 17, 9 and 3 deg, each on its own
    pace: Range  # of the paper's periods 1, 1 and 1.5 s

    @classmethod
    def parse(cls, table: Mapping[str, Any], where: str, files: Files, seconds: Range) -> "PendulumMotion":
        """Return the motion of a table."""
        check_keys(table, ("kind", "weight", "amplitude", "pace"), where)
        amplitude = parse_range(table.get("amplitude", [0.6, 1.6]), f"{where}.amplitude", 0.0)
        pace = parse_range(table.get("pace", [0.7, 1.4]), f"{where}.pace", 0.0, 10.0, open_low=True)
        return cls(weight(table, where), amplitude, pace)

    def suits(self, rig: RigRange) -> bool:
        """Return whether a rig is a pendulum."""
        return rig.tree.ball is not None

    def draw(self, rng: np.random.Generator, seconds: float) -> tuple[str, Motion]:
        """Return an ellipse with random phases, a quarter of a period between x and y."""
        a = np.deg2rad([17.0, 9.0, 3.0]) * self.amplitude.draw(rng, (3,))
        pace, (p, q) = self.pace.one(rng), rng.uniform(0, 2 * np.pi, 2)
        side = rng.choice([-1.0, 1.0])
        return self.kind, AngleMotion(
            tilt=Sines(a[0], pace, p), spin=Sines(a[1], pace, p + side * np.pi / 2), heading=Sines(a[2], pace / 1.5, q)
        )


@dataclass(frozen=True)
class FileMotion:
    """A piece of a measured or computed motion, begun anywhere in it."""

    kind: ClassVar[str] = "file"
    weight: float
    path: str
    file: MotionFile

    @classmethod
    def parse(cls, table: Mapping[str, Any], where: str, files: Files, seconds: Range) -> "FileMotion":
        """Return the motion of a table and of the file that it names."""
        check_keys(table, ("kind", "weight", "path"), where)
        path = table.get("path")
        if not isinstance(path, str):
            raise InputError(f"{where}.path: expected a path beside the spec, got {path!r}")
        file = MotionFile.parse(files(path, f"{where}.path"), path)
        if file.duration < seconds.high + BEYOND:
            raise InputError(
                f"{path}: expected {seconds.high + BEYOND:g} s or more for recordings of {seconds.high:g} s, "
                f"got {file.duration:g} s"
            )
        return cls(weight(table, where), path, file)

    def suits(self, rig: RigRange) -> bool:
        """Return True: coordinates that a rig does not have mean nothing to it."""
        return True

    def draw(self, rng: np.random.Generator, seconds: float) -> tuple[str, Motion]:
        """Return the motion from a random time on."""
        start = rng.uniform(0.0, max(self.file.duration - seconds, 0.0))
        return f"file {self.path}", Later(self.file.motion, start)


BEYOND = 0.5  # s that motions go on after a recording's end, for clocks that are late or fast
Parse = Callable[[Mapping[str, Any], str, Files, Range], MotionRange]
KINDS: dict[str, Parse] = {
    "random": RandomMotion.parse,
    "olsson2020": OlssonMotions.parse,
    "pendulum": PendulumMotion.parse,
    "file": FileMotion.parse,
    "swing": SwingMotion.parse,
}
"""The kinds of motion by name."""
