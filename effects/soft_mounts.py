"""Sensors on springs and dampers. Their displacement is a state of its own, tied to the motion by Newton's law.

Priors: foam, straps and soft tissue let an IMU swing at a few to some tens of hertz (10 Hz, a factor of two
either way), lightly damped (0.1, a factor of e either way); it moves by up to a centimetre and turns by up to
0.1 rad; its centre of mass is off the pivot by a few millimetres, its sensing point by a few centimetres.
"""

from collections.abc import Mapping
from copy import copy
from dataclasses import replace
from typing import Literal

import numpy as np

from imubench.arrays import Array
from imubench.effects import collocation
from imubench.effects.effect import Effect, Equation, Numbers, Parameter, Scene, State, Values
from imubench.jets import Jet, cross
from imubench.links import Link, shift, small_turn
from imubench.sim.rigs import HEAVIEST, Mount, springs

FREQUENCIES = np.array([3.0, 4.5, 6.5, 9.5, 14.0, 20.0, 30.0])  # Hz, starts half an octave apart
GYRATION = 0.015  # m, radius of gyration of an IMU in its box about its pivot


def _frequency(count: int, axes: Literal["sensor", "segment"], about: bool) -> Parameter:
    return Parameter("frequency", (count,), "Hz", 0.7, start=10.0, log=True, axes=axes, about=about)


class Sprung(Effect):
    """What sits on springs and dampers."""

    on_springs = True

    size: Array | None = None  # (3,) of its state; springs that bend pull w^2 x (1 + bend (q - 1)), q as in `bent`

    @property
    def straight_springs(self) -> bool:
        return self.size is None

    def bending(self, size: Array) -> "Sprung":
        """Return the same on springs whose stiffness changes with how far they are pushed, `size` (3,) of it."""
        out = copy(self)
        out.size = size
        out.parameters = (*self.parameters, Parameter("bend", (3,), "1", 1.0, reported=False))
        return out

    def in_time(self, values: Mapping[str, Array], step: float) -> Mapping[str, Array]:
        return {**values, "frequency": np.log(collocation.in_time(np.exp(values["frequency"]), step))}

    def collocated(self, values: Mapping[str, Array], step: float) -> Mapping[str, Array]:
        return {**values, "frequency": np.log(collocation.collocated(np.exp(values["frequency"]), step))}

    def pull(self, x: Jet, rate: Jet, p: Values) -> Jet:
        """Return 2 z w x' + w^2 x (n, 3), w = 2 pi f: what springs and dampers take, per unit of mass."""
        w = 2 * np.pi * p["frequency"]
        pushed = x if self.size is None else x + p["bend"] * x * (self.bent(x) - 1.0)
        return 2.0 * p["damping_ratio"] * w * rate + w * w * pushed

    def bent(self, x: Jet) -> Jet:
        """Return x^2 / size^2, about 1 where the state is as large as usual, bounded by 9 where it runs off."""
        if self.size is None:
            raise ValueError("straight springs have no size")
        square = x * x
        return square / (square / 9.0 + self.size**2)


class SoftMount(Sprung):
    """The sensor is displaced on springs and dampers; the model's pose is that of the unloaded springs."""

    name, place = "soft_mount", "imu"
    phrase = "a soft mount that {imu} moves on as on springs"
    law = "f + 2 z w x' + w^2 x = 0: f the specific force at the sensor, x its displacement, segment axes"
    states = (State("displacement", 3, 0.01),)

    def __init__(self, axes: int = 3) -> None:
        self.variant = "" if axes == 3 else "isotropic"
        self.parameters = (
            _frequency(axes, "segment", about=False),
            Parameter("damping_ratio", (), "1", 1.0, start=0.1, log=True),
        )

    def grid(self, seconds: float) -> dict[str, Array]:
        return {"frequency": FREQUENCIES}

    def mount(self, link: Link, scene: Scene, p: Values) -> Link:
        return shift(*scene.own("displacement")) @ link

    def equations(self, scene: Scene, p: Values) -> list[Equation]:
        mount, sensor = scene.mounted()
        x, rate, _ = scene.own("displacement")
        return [Equation("balance", mount.turn.forth(sensor.force) + self.pull(x, rate, p), 0.1)]

    def on_mount(self, mount: Mount, numbers: Numbers) -> Mount:
        return replace(mount, translation=springs(numbers["frequency"], numbers["damping_ratio"]))


class RockingMount(Sprung):
    """The sensor rocks about a pivot on springs and dampers.

    Torques on a body of mass m about its pivot, its inertia m k^2 about every axis, c its centre of mass
    and f the specific force at the pivot, all in the rocking sensor's axes: m k^2 w' + m c x f = torque.
    """

    name, place = "rocking_mount", "imu"
    phrase = "a mount that {imu} rocks on"
    rocks = True
    law = "w' + com x f / gyration^2 + 2 z w0 rho' + w0^2 rho = 0: rho the rotation vector, w' and f the sensor's"
    states = (State("rotation", 3, 0.1),)
    settings = {"gyration": GYRATION}  # noqa: RUF012

    def __init__(self, axes: int = 3) -> None:
        self.variant = "" if axes == 3 else "isotropic"
        self.parameters = (
            _frequency(axes, "sensor", about=True),
            Parameter("damping_ratio", (axes,), "1", 1.0, start=0.1, log=True, about=True),
            Parameter("com", (3,), "m", 0.003, about=True),
            Parameter("lever", (3,), "m", 0.02, about=True),
        )

    def grid(self, seconds: float) -> dict[str, Array]:
        return {"frequency": FREQUENCIES}

    def mount(self, link: Link, scene: Scene, p: Values) -> Link:
        return link @ shift(-p["lever"]) @ small_turn(*scene.own("rotation")) @ shift(p["lever"])

    def equations(self, scene: Scene, p: Values) -> list[Equation]:
        _, sensor = scene.mounted()
        rho = scene.own("rotation")
        pivot = sensor.child(shift(-p["lever"]))
        driven = sensor.accel + cross(p["com"], pivot.force) * (1 / GYRATION**2)
        return [Equation("balance", driven + self.pull(rho[0], small_turn(*rho).rate, p), 0.1)]

    def on_mount(self, mount: Mount, numbers: Numbers) -> Mount:
        """Only com / gyration^2 shows, and a body that turns about every axis alike is no heavier on one side than so.

        So a body that is too heavy on one side is played by a smaller one of the same com / gyration^2.
        """
        com = np.asarray(numbers.get("com", np.zeros(3)), dtype=float)
        gyration = float(numbers.get("gyration", mount.gyration))
        smaller = min(1.0, 0.99 * HEAVIEST * gyration / max(float(np.linalg.norm(com)), 1e-12))
        return self.injected_mount(
            mount, {**numbers, "com": com * smaller**2, "gyration": np.asarray(gyration * smaller)}
        )

    def injected_mount(self, mount: Mount, numbers: Numbers) -> Mount:
        return replace(
            mount,
            rotation=springs(numbers["frequency"], numbers["damping_ratio"]),
            com=numbers["com"],
            gyration=float(numbers["gyration"]),
            lever=numbers.get("lever", np.zeros(3)),
        )


EFFECTS: tuple[Effect, ...] = (SoftMount(), SoftMount(axes=1), RockingMount(), RockingMount(axes=1))
