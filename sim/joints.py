"""What a joint does beside turning, as numbers: play across its axis, and an end stop.

Of a hinge with the angle q, segment 1's frame 1 and segment 2's frame 2, the chain is::

    p_2 = p_1 + R_1 slide q,    R_2 = R_1 Ry(q) Rx(c1 q) Rz(c2 q) exp(phi e),    e = (cos d, 0, sin d)

`slide` (3) m/rad and c = (c1, c2) rad/rad follow the angle; phi, the play, moves by itself.
"""

from dataclasses import dataclass

import numpy as np

from imubench.arrays import Array
from imubench.errors import InputError
from imubench.recording import positive
from imubench.sim.signals import Signal

KNOCK_FREQUENCY, KNOCK_RATIO = 40.0, 0.5
"""Hz and damping ratio of a loose limb on a stop of its play: steel and plastic are stiffer, yet an IMU of 100 Hz sees
no difference, and under its own weight (40 rad/s^2 of a 20 cm limb) it gives way by less than 1 mrad."""
IMPEDANCE = 1e-4
"""MuJoCo's least impedance. With it a limit is a one-sided spring and damper: the acceleration is (1 - d) of the one
without plus d of the reference, and the reference is -(stiffness r + damping v) / d for MuJoCo's direct `solref`."""


@dataclass(frozen=True)
class Play:
    """Segment 2 is loose: it turns by phi about e, across the hinge axis, between two stops.

    With J its inertia about e, c its centre of mass, m its mass, f the specific force at the joint and w' the angular
    acceleration it would have without play, all in its own axes, between the stops::

        (J / share) (phi'' + 2 z w phi' + w^2 phi) = -e . (I w' + m c x f) - (terms of order phi and w^2)

    w = 2 pi `frequency`; 0: no springs.
    """

    range: float  # rad, to either side
    direction: float = 0.0  # rad, of e from the segment's x axis towards its z axis
    frequency: float = 0.0  # Hz
    damping_ratio: float = 0.0
    share: float = 1.0  # of its load that reaches it, where hands or muscles bear the rest
    path: tuple[Signal, Signal] | None = None  # rad, about e and about `beside`: it turns like this, whatever happens

    def __post_init__(self) -> None:
        positive(self.range, "play.range")
        for key in ("frequency", "damping_ratio"):
            positive(getattr(self, key), f"play.{key}", or_zero=True)
        if not 0 < self.share <= 1:
            raise InputError(f"play.share: expected a number above 0 and up to 1, got {self.share:g}")

    @property
    def axis(self) -> Array:
        """The unit vector e (3,) in segment 2."""
        return np.array([np.cos(self.direction), 0.0, np.sin(self.direction)])

    @property
    def beside(self) -> Array:
        """The unit vector (3,) across the hinge axis and e, in segment 2."""
        return np.array([-np.sin(self.direction), 0.0, np.cos(self.direction)])


@dataclass(frozen=True)
class Stop:
    """A one-sided spring and damper beyond an angle: torque -(stiffness depth + damping rate), never a pull.

    Of a ball joint the angle is the swing; see `sim.ball`.
    """

    angle: float  # rad; its sign is the stop's side
    stiffness: float = 100.0  # N m/rad
    damping: float = 0.3  # N m s/rad

    def __post_init__(self) -> None:
        positive(self.stiffness, "stop.stiffness")
        positive(self.damping, "stop.damping", or_zero=True)
        if not np.isfinite(self.angle):
            raise InputError(f"stop.angle: expected a finite number, got {self.angle:g}")

    @property
    def side(self) -> float:
        """1 where it ends the joint's way at positive angles, -1 where at negative ones."""
        return -1.0 if self.angle < 0 else 1.0
