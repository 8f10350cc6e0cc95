"""Terms without a name: smooth functions of what a recording shows anyway, for what no effect explains.

A term adds sum_k c_k phi_k(t) to the readings of one IMU, or to the torque in free swings. Its signals phi are
computed once, from a fit, and held; the fit then finds c. Signals are in units of the noise, so that a weight says
how many standard deviations of noise its signal is worth.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.problem.bspline import Held, interpolated
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.residuals import CHANNELS, SWING_EQUATION, Rows
from imubench.effects import traits_of
from imubench.effects.effect import Effect, Error, Parameter, Place, Reading, Scene, Values
from imubench.jets import Jet

JOINT_RATE = "the joint's rate"
OWN = "its own reading"
ANGULAR_ACCELERATION = "angular acceleration"
JUMP = "time: a jump"
LATE = "a little later"
LATER = f"how the sensor turns and is pushed, {LATE}"
SERIES = (ANGULAR_ACCELERATION, LATER)  # what a delay or a filter does to first order, and to second


@dataclass(frozen=True)
class Term:
    """Signals that something unknown may consist of."""

    at: str  # imu1, imu2, joint
    part: str  # gyro, accel, torque, or both of an IMU
    goes_with: str  # in words
    time: Array  # (n,) s on the splines
    signals: Mapping[str, Held]  # gyro, accel (n, 3, k) in their units, or torque (n, k)
    channel: tuple[int, ...]  # of each signal: the channel that it enters, -1 for several
    drift: bool = False  # so slow that its own fit takes what colour the noise has there
    timed: bool = False  # a function of time: what it is in one second only the seconds beside it tell

    def __post_init__(self) -> None:
        object.__setattr__(self, "signals", {part: s.astype(np.float32) for part, s in self.signals.items()})

    @property
    def count(self) -> int:
        """How many weights it has."""
        return len(self.channel)

    @property
    def jumps(self) -> bool:
        """Whether it is a step, once."""
        return self.goes_with.startswith(JUMP)

    def holds(self, effect: str) -> bool:
        """Return whether it holds a law of friction, a torque with the rate: neither stands in for the other."""
        return self.goes_with == JOINT_RATE and traits_of(effect).friction

    def only(self, channel: int) -> "Term":
        """Return the part that enters one channel."""
        own = np.flatnonzero(np.array(self.channel) == channel)
        signals = {part: s[..., own] for part, s in self.signals.items()}
        return replace(self, signals=signals, channel=(channel,) * len(own))


class Unknown(Effect):
    """Something at an IMU that no effect explains, as a term."""

    name, law = "unknown", "reads + sum_k weight_k phi_k(t), phi_k held"
    place: ClassVar[Place] = "imu"
    on_sensor = False  # nobody knows whether it is the sensor's or its seat's

    def __init__(self, term: Term, std: float) -> None:
        self.term = term
        self.variant = f"{term.part}, {term.goes_with}, {sorted(set(term.channel))}"
        self.parameters = (Parameter("weight", (term.count,), "1", std),)

    def added(self, part: str, time: Jet, p: Values) -> Jet | None:
        """Return what the term adds to one part's readings (n, 3) or torque (n, 1); a clock's error moves nothing."""
        signal = self.term.signals.get(part)
        if signal is None:
            return None
        flat = signal.reshape(len(signal), -1)
        at = interpolated(time.value[:, 0], self.term.time, flat).reshape(len(time.value), -1, self.term.count)
        weight = p["weight"]
        value = np.einsum("nmk,k->nm", at, weight.value[0])
        return Jet(value, {key: np.matmul(at, d[0]) for key, d in weight.blocks.items()})

    def error(self, reading: Reading, p: Values) -> Error:
        """Return the term's part of the readings."""
        return Error(self.added("gyro", reading.time, p), self.added("accel", reading.time, p))


class UnknownTorque(Unknown):
    """The same at the joint, in free swings."""

    law, place = "torque sum_k weight_k phi_k(t), phi_k held", "joint"
    needs = ("free_swings",)

    def torque(self, scene: Scene, p: Values) -> Jet | None:
        """Return the term's torque (n, 3) about the joint's axis."""
        size = self.added("torque", scene.time, p)
        return None if size is None else size * scene.jointed()[1]


def signals_of(fit: Fit, term: Term) -> list[tuple[Rows, Array]]:
    """Return the rows that a term enters, and its whitened signals (n m, k) there; a torque's sign turned."""
    names = {SWING_EQUATION: "torque"} if term.part == "torque" else {f"{term.at}.{p}": p for p in term.signals}
    out = []
    for rows in fit.rows:
        if rows.name in names:
            known = term.signals[names[rows.name]]
            n, m = rows.residual.value.shape
            values = interpolated(rows.time, term.time, known.reshape(len(known), -1)).reshape(n, -1, term.count)
            if rows.name == SWING_EQUATION:
                values = -np.broadcast_to(values, (n, m, term.count))
            std = np.broadcast_to(rows.std, (n, m))
            out.append((rows, (values / std[:, :, None]).reshape(n * m, term.count)))
    return out


def channels_of(part: str, count: int) -> tuple[str, ...]:
    """Return the names of the `count` channels of a part: an IMU's triple, or a torque about one axis or three."""
    return CHANNELS.get(part, ("torque",) if count == 1 else ("torque_x", "torque_y", "torque_z"))


__all__ = ["Term", "Unknown", "UnknownTorque", "channels_of", "signals_of"]
