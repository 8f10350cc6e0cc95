"""Free swings: a limb or rod that is let go, at rest or not, and moves as gravity and its joint have it."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from imubench import rotations
from imubench.arrays import Array
from imubench.dataset.ranges import Range, check_keys, parse_range, weight
from imubench.dataset.rig_ranges import RigRange
from imubench.sim.rigs import Rig
from imubench.sim.swing import Start, swing
from imubench.truth import Truth

STEP = 2e-3  # s, of order 4: a 300th of the fastest swings' period
SPRUNG_STEP = 2e-4  # s, of order 1: a 200th of the period of springs of 25 Hz
STOPPED_STEP = 5e-4  # s: a hundredth of a bounce on an end stop
CLEAR = 0.05  # rad, that a limb is let go before an end stop
WEIGHTLESS = 1e-6  # kg: an IMU belongs to the segment that is declared


@dataclass(frozen=True)
class FreeSwing:
    """How a rig is let go, in place of a motion."""

    deflection: float  # rad, from where it would hang
    direction: float  # rad, which way a pendulum is deflected; a hinge: positive above pi
    rate: Array  # (3,) rad/s, segment axes; a hinge takes the second

    def start(self, rig: Rig) -> Start:
        """Return the state in which the rig is let go: nobody presses it into an end stop, but to its other side."""
        if rig.tree.ball is not None:
            axis = np.array([np.cos(self.direction), np.sin(self.direction), 0.0])
            turned = rotations.exp(self.deflection * axis)
            z = rotations.rotate(turned, [0.0, 0.0, 1.0])
            if rig.stop is not None and rig.stop.side * (np.arctan2(z[0], z[2]) - rig.stop.angle) > -CLEAR:
                turned = rotations.exp(-self.deflection * axis)
            return Start(quaternion=turned, rate=self.rate)
        side, rest = (1.0 if self.direction > np.pi else -1.0), hanging(rig)
        if rig.stop is not None and rig.stop.side * (rest + side * self.deflection - rig.stop.angle) > -CLEAR:
            side = -side
        return Start(angle=rest + side * self.deflection, angle_rate=float(self.rate[1]))

    def play(self, rig: Rig, seconds: float, rate: float) -> Truth:
        """Return the truth of the swing, `rate` samples a second."""
        light = replace(rig, mounts=tuple(replace(m, mass=WEIGHTLESS) for m in rig.mounts))
        step = SPRUNG_STEP if rig.sprung else STOPPED_STEP if rig.stop is not None else STEP
        return swing(light, self.start(rig), seconds, rate, step=step)


def hanging(rig: Rig) -> float:
    """Return the hinge angle, rad, at which segment 2's centre of mass is lowest."""
    up = rotations.rotate_back(rig.base_quaternion, [0.0, 0.0, 1.0])  # segment 1's axes
    com = rig.segments[1].com
    # Ry(q) com has the height c cos q + s sin q, lowest opposite to (c, s).
    c, s = up[0] * com[0] + up[2] * com[2], up[0] * com[2] - up[2] * com[0]
    return float(np.arctan2(-s, -c))


@dataclass(frozen=True)
class SwingMotion:
    """Swings of a pendulum, or of a hinge whose base is fixed; the whole recording is free."""

    kind: ClassVar[str] = "swing"
    weight: float
    deflection: Range
    rate: Range

    @classmethod
    def parse(cls, table: Mapping[str, Any], where: str, *_: object) -> "SwingMotion":
        """Return the swings of a table."""
        check_keys(table, ("kind", "weight", "deflection", "rate"), where)
        return cls(
            weight(table, where),
            parse_range(table.get("deflection", [0.4, 1.6]), f"{where}.deflection", 0.0, np.pi),
            parse_range(table.get("rate", {"std": 0.5}), f"{where}.rate"),
        )

    def suits(self, rig: RigRange) -> bool:
        """Return whether a rig hangs from something."""
        return rig.tree.ball is not None or rig.base == "fixed"

    def draw(self, rng: np.random.Generator, seconds: float) -> tuple[str, FreeSwing]:
        """Return a way to let go; `seconds` mean nothing to it."""
        deflection, direction = self.deflection.one(rng), rng.uniform(0.0, 2 * np.pi)
        return self.kind, FreeSwing(deflection, direction, self.rate.draw(rng, (3,)))
