"""Torques at a joint that swings free: the sum of what the effects of a case add to gravity.

    viscous_friction  -c w              dry_friction  -t w/|w|         air_drag  -d |w| w
    joint_spring      -k (q - q0)       end_stop      a one-sided stiff spring beyond `angle`
    cogging           -a sin(n q)       (not in the table)
    wind              a random torque of `std` N m below `band` Hz (not in the table)

w/|w| is tanh(|w| / 0.01) w/|w|, so that a joint at rest can stay there. q is the hinge angle, or the pendulum's swing
(see `swing.Ball`). `inertia` divides the inertia about the pivot by its `scale` and leaves m l.
"""

from dataclasses import dataclass
from math import pi, sin, tanh

import numpy as np

from imubench.proof.motion import band_noise, steady
from imubench.proof.options import Effect, find
from imubench.proof.rotation import Array

STICK = 0.01  # rad/s, below which dry friction fades
STOP_FREQUENCY = 25.0  # Hz, of the segment bouncing on its stop
STOP_LOSS = 0.15  # s/rad, Hunt and Crossley: torque -k x (1 + loss dx/dt), continuous at contact


@dataclass(frozen=True)
class Torques:
    """The sum of the laws above; `wind` (n,) N m on the fine grid."""

    c: float
    t: float
    d: float
    k: float
    q0: float
    stop: float
    stop_k: float
    cogging: float
    cogs: float
    scale: float
    wind: Array

    def along(self, speed: float) -> float:
        """Return the factor on w of the resisting torque at |w| = `speed` (N m s/rad, negative)."""
        dry = self.t * tanh(speed / STICK) / speed if speed > 1e-9 else self.t / STICK
        return -(self.c + dry + self.d * speed)

    def beyond(self, q: float) -> bool:
        """Return whether a hand would have to press the joint into its stop to get to the angle q."""
        return bool(self.stop_k) and (q - self.stop) * (1.0 if self.stop >= 0 else -1.0) > -0.05

    def about(self, q: float, w: float) -> float:
        """Return the torque that depends on the angle q and, in contact, on its rate w."""
        torque = -self.k * (q - self.q0)
        if self.cogging:
            torque -= self.cogging * sin(self.cogs * q)
        if self.stop_k:
            side = 1.0 if self.stop >= 0 else -1.0
            deep = side * (q - self.stop)
            if deep > 0:
                torque -= side * self.stop_k * deep * max(0.0, 1 + STOP_LOSS * 2 * pi * side * w)
        return torque


def torques(effects: list[Effect], inertia: float, t: Array, rng: np.random.Generator) -> Torques:
    """Return the torques of a case's effects; `inertia` kg m^2 about the swing axis scales the stop."""

    def value(name: str, key: str) -> float:
        found = find(effects, name)
        return float(found[key]) if found else 0.0

    stop, wind = find(effects, "end_stop"), find(effects, "wind")
    gust = 0 * t
    if wind:
        gust = band_noise(rng, (0.05, float(wind["band"])), float(wind["std"])).along(steady(t))[0]
    return Torques(
        value("viscous_friction", "c"),
        value("dry_friction", "t"),
        value("air_drag", "d"),
        value("joint_spring", "k"),
        value("joint_spring", "q0"),
        float(stop["angle"]) if stop else 0.0,
        inertia * (2 * pi * STOP_FREQUENCY) ** 2 if stop else 0.0,
        value("cogging", "torque"),
        value("cogging", "cogs"),
        value("inertia", "scale") or 1.0,
        gust,
    )
