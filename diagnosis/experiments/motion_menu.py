"""Motions that a person can do with a rig, each as what its segments would do over time."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from imubench import rotations
from imubench.arrays import Array
from imubench.diagnosis.config.simulation import EXPERIMENT
from imubench.diagnosis.problem.dynamics_factors import inertia_about_joint
from imubench.recording import Body


@dataclass(frozen=True)
class Course:
    """A rig's motion at times (n,)."""

    turn: Array  # (n, 4) segment 1 -> world, or the limb; continuous
    place: Array  # (n, 3) m, segment 1's origin
    angle: Array  # (n,) rad, hinge angle


@dataclass(frozen=True)
class Swing:
    """What a free swing needs to know."""

    body: Body
    base: Array  # (3, 3) segment 1 -> world
    gravity: float  # m/s^2
    torque: Callable[[float, float], float]  # N m, of what resists, at an angle and a rate


@dataclass(frozen=True)
class Stage:
    """One way to move a rig; `swing` is None for what a hand does."""

    play: Callable[[Array, Swing | None], Course]
    free: bool = False  # an equation of motion holds
    swapped: bool = False  # the two sensors have changed places
    loaded: float = 0.0  # of the body's mass, added at its centre of mass


@dataclass(frozen=True)
class Motion:
    """An entry of the menu; the stages share the time."""

    name: str
    words: str  # "20 s of ..."
    stages: tuple[Stage, ...]


def _steps(time: Array, values: Array) -> Array:
    """Return values (k, m) held one after the other over times (n,), each reached within a third of its time."""
    place = time / (time[-1] + 1e-9) * len(values)
    at = np.clip(place.astype(int), 0, len(values) - 1)
    u = np.clip(3 * (place - at), 0.0, 1.0)[:, None]
    before = values[np.maximum(at - 1, 0)]
    return np.asarray(before + (values[at] - before) * u**3 * (10 + u * (6 * u - 15)))


def _still(time: Array) -> tuple[Array, Array, Array]:
    return np.zeros((len(time), 3)), np.zeros((len(time), 3)), np.zeros(len(time))


def _turned(angles: Array) -> Array:
    """Return Rz Ry Rx of angles (n, 3) rad as quaternions (n, 4)."""
    x, y, z = (rotations.from_axis_angle(np.eye(3)[i], angles[:, i]) for i in range(3))
    return rotations.multiply(z, rotations.multiply(y, x))


def poses(time: Array, _: Swing | None) -> Course:
    """Six poses held still, the joint bent differently in each."""
    quarter = np.pi / 2
    held = np.array([[0, 0, 0], [quarter, 0, 0], [0.6, 0.6, 0], [0, -1.2, 0], [-quarter, 0, 0], [2.6, 0.3, 0]])
    bent = np.array([0.0, 1.0, -1.0, 0.5, -0.5, 1.4])
    return Course(_turned(_steps(time, held)), np.zeros((len(time), 3)), _steps(time, bent[:, None])[:, 0])


def tilts(time: Array, _: Swing | None) -> Course:
    """Slow tilts to all sides."""
    angles, place, _angle = _still(time)
    angles[:, 0], angles[:, 1] = 1.2 * np.sin(0.5 * time), 1.0 * np.sin(0.37 * time + 1.0)
    return Course(_turned(angles), place, 0.8 * np.sin(0.43 * time))


def spin(axis: int) -> Callable[[Array, Swing | None], Course]:
    """Turning round and round about one axis of segment 1 at 2 rad/s, the joint held."""

    def play(time: Array, _: Swing | None) -> Course:
        angles, place, angle = _still(time)
        angles[:, axis] = EXPERIMENT.spin_rad_s * time
        return Course(_turned(angles), place, angle + EXPERIMENT.held_rad)

    return play


def bending(time: Array, _: Swing | None) -> Course:
    """The joint bent to and fro at up to 2 rad/s, segment 1 held still."""
    angles, place, _angle = _still(time)
    return Course(_turned(angles), place, 0.8 * np.sin(EXPERIMENT.spin_rad_s / 0.8 * time))


def taps(time: Array, _: Swing | None) -> Course:
    """The rig knocked twice a second, each time from another side: 5 mm within 40 ms."""
    angles, place, angle = _still(time)
    for k in range(int(2 * time[-1])):
        direction = np.random.default_rng(k).standard_normal(3)
        bump = np.exp(-0.5 * ((time - 0.5 * k - 0.3) / 0.02) ** 2)
        place = place + 0.005 * np.outer(bump, direction / np.linalg.norm(direction))
        angles[:, k % 3] += 0.01 * bump
        angle = angle + 0.02 * (k % 2) * bump
    return Course(_turned(angles), place, angle + 0.3)


def swing(time: Array, how: Swing | None) -> Course:
    """A free swing from 1 rad about +y, as the body's weight and what resists it have it."""
    angles, place, _angle = _still(time)
    assert how is not None  # a stage that is free brings its swing
    angle = swung(time, how)
    return Course(_turned(angles), place, angle)


def swung(time: Array, how: Swing) -> Array:
    """Return the angle (n,) rad of a body that swings about +y from 1 rad beyond hanging."""
    moment, inertia = how.body.mass * how.body.com, inertia_about_joint(how.body)[1, 1]
    down = how.base.T @ np.array([0.0, 0.0, -how.gravity])

    def pull(q: float) -> float:
        x, z = down[0] * np.cos(q) - down[2] * np.sin(q), down[0] * np.sin(q) + down[2] * np.cos(q)
        return float(moment[2] * x - moment[0] * z)

    around = np.linspace(-np.pi, np.pi, 721)
    torque = np.array([pull(q) for q in around])
    falls = np.flatnonzero((torque[:-1] > 0) & (torque[1:] <= 0))  # where it is driven back from both sides
    q, rate = float(around[falls[0]] if len(falls) else 0.0) + EXPERIMENT.release_rad, 0.0
    count = int(np.ceil((time[-1] - time[0]) / EXPERIMENT.step_s)) + 2
    out = np.empty(count)
    for i in range(count):
        out[i] = q
        rate += EXPERIMENT.step_s * (pull(q) + how.torque(q, rate)) / inertia
        q += EXPERIMENT.step_s * rate
    return np.interp(time - time[0], EXPERIMENT.step_s * np.arange(count), out)


MENU: tuple[Motion, ...] = (
    Motion("static poses", "poses held still, six of them", (Stage(poses),)),
    Motion("slow tilts", "slow tilts at up to 0.6 rad/s", (Stage(tilts),)),
    Motion("on-axis spin", "on-axis spin at 2 rad/s, the joint held", (Stage(spin(1)),)),
    Motion("spin across", "spin across the joint's axis at 2 rad/s, the joint held", (Stage(spin(0)),)),
    Motion("upright spin", "spin about the upright axis at 2 rad/s, the joint held", (Stage(spin(2)),)),
    Motion("bending", "bending the joint to and fro at up to 2 rad/s, segment 1 held still", (Stage(bending),)),
    Motion("taps", "taps from all sides, two a second", (Stage(taps),)),
    Motion("free swing", "free swing from 1 rad", (Stage(swing, free=True),)),
    Motion(
        "sensors swapped",
        "slow tilts, for one half with the two sensors in each other's place",
        (Stage(tilts), Stage(tilts, swapped=True)),
    ),
    Motion(
        "mass added",
        "free swings from 1 rad, one with half the mass added at the centre of mass",
        (Stage(swing, free=True), Stage(swing, free=True, loaded=0.5)),
    ),
)
"""What a person may be asked to do."""
