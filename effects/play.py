"""A hinge with play: segment 2 rotates across its axis, freely within a range or on springs.

Free to turn by phi about e, across the hinge axis, segment 2 (mass m, its inertia m k^2 about e, c its centre of mass,
f the specific force at the joint's centre, all in its own axes) has, with springs and dampers in the joint and the
share s of its load, where hands or muscles bear the rest::

    phi'' + 2 z w phi' + w^2 phi = -s e . (w' + arm x f),   arm = c / k^2,  w' the segment's without play

to first order in phi, with w = 2 pi frequency; e = (cos d, 0, sin d) in segment 2, d its direction. Without springs,
between stops that nobody has measured, it falls from one side to the other: a spline that may jump.

Priors: a worn hinge gives some hundredths of a radian across its axis (0.04 rad); a limb sways in it at some hertz
(5 Hz, a factor of two either way), damped (0.2, a factor of e either way), by all of its load or by a part (1, a factor
of 4.5 either way); its centre of mass is 0.15 m from its joint, its radius of gyration 0.2 m (an arm of 4 a metre).
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from imubench.arrays import Array
from imubench.effects.effect import Effect, Equation, Found, Numbers, Parameter, Scene, State, Values
from imubench.effects.traits import Correction
from imubench.jets import Jet, cross, dot
from imubench.links import Link, small_turn, spin
from imubench.models.tree import HINGE
from imubench.sim.joints import Play
from imubench.sim.rigs import Rig, Segment

QUICK, WHOLE = 0.5, 0.8  # s, windows in which play's direction and its range are seen
REACHED = 0.9  # of the windows, that span less than what is reported as a range
DRAWS = 100  # of windows, for the scatter of both
REACH = 0.25  # of a range, how well it is known: what drifts widens it
WITHIN, SPRUNG = 0.95, 0.15  # of the time, that springs are within what is reported; of that, how well it is known
FREQUENCIES = np.array([1.5, 3.0, 6.0, 12.0])  # Hz, starts an octave apart
DIRECTIONS = np.linspace(0.0, np.pi, 8, endpoint=False)  # rad; beyond they come again
BEYOND = 4.0  # of the range that springs are within most of the time: where their stops are put
NARROW = 0.1  # of its gyration radius: how far off its axis a loose limb's com is put; see `loose`
X, Z = np.array([[1.0], [0.0], [0.0]]), np.array([[0.0], [0.0], [1.0]])


class JointPlay(Effect):
    """Segment 2 rotates about one axis across the hinge's, within a range, and may fall from one side to the other."""

    name, place, law = "joint_play", "joint", "R2 = R1 Ry(q) exp(phi e), |phi| < range"
    phrase = "play across the hinge axis"
    joints, needs = (HINGE,), ("imus",)
    loosens = knocks = True
    slow_share = 0.1  # of two mounts that creep 0.002 and 0.005, of play 0.6
    states: tuple[State, ...] = (State("rotation", 1, 0.04, jumps=True),)
    parameters: tuple[Parameter, ...] = (Parameter("direction", (), "rad", 2.0),)
    found: tuple[Found, ...] = (Found("range", (), "rad"),)

    def grid(self, seconds: float) -> dict[str, Array]:
        return {"direction": DIRECTIONS}

    def joint(self, link: Link, scene: Scene, p: Values) -> Link:
        e = along(p["direction"])
        return link @ small_turn(*(x * e for x in scene.own("rotation")))

    def read(self, values: Mapping[str, Array], states: Mapping[str, Array], step: float) -> dict[str, Array]:
        """Range in short windows: there a joint knocks from side to side, and what drifts hardly moves."""
        return {"range": reached(windows(states["rotation"], step, WHOLE)[:, :, 0])}

    def read_error(self, values: Mapping[str, Array], states: Mapping[str, Array], step: float) -> dict[str, Array]:
        """Of other windows, and a quarter: eleven of two blind runs were off by 29 % RMS, -43 to 29 %."""
        whole = windows(states["rotation"], step, WHOLE)[:, :, 0]
        return {"range": np.hypot(np.std([reached(w) for w in drawn(whole)]), REACH * reached(whole))}

    @property
    def correction(self) -> Correction:
        """On springs, too: a report tells neither how stiff they are nor which of the kinds it is."""
        return Correction.FREE

    def on_rig(self, rig: Rig, numbers: Numbers, weighed: bool) -> Rig:
        return replace(rig, play=Play(_reach(numbers), _direction(numbers)))

    def injected_rig(self, rig: Rig, numbers: Numbers) -> Rig:
        """On springs where a frequency is told, and within its range all the same."""
        frequency, ratio = (float(numbers.get(key, np.zeros(()))) for key in ("frequency", "damping_ratio"))
        return replace(rig, play=Play(float(numbers["range"]), float(numbers["direction"]), frequency, ratio))


class WobblyPlay(JointPlay):
    """Segment 2 wobbles about any axis across the hinge's: a real loose hinge did, without falling over."""

    variant, law = "wobbly", "R2 = R1 Ry(q) exp(a, 0, b), |(a, b)| < range"
    states = (State("rotation", 2, 0.04),)
    parameters = ()
    found = (Found("range", (), "rad"), Found("direction", (), "rad"))

    def grid(self, seconds: float) -> dict[str, Array]:
        return {}

    def joint(self, link: Link, scene: Scene, p: Values) -> Link:
        return link @ small_turn(*(x.at(np.hstack([X, Z])) for x in scene.own("rotation")))

    def read(self, values: Mapping[str, Array], states: Mapping[str, Array], step: float) -> dict[str, Array]:
        """Range and direction of the axis along which the two rotations vary most; a direction is known up to pi."""
        quick, whole = (windows(states["rotation"], step, seconds) for seconds in (QUICK, WHOLE))
        return dict(zip(("range", "direction"), _played(quick, whole), strict=True))

    def read_error(self, values: Mapping[str, Array], states: Mapping[str, Array], step: float) -> dict[str, Array]:
        quick, whole = (windows(states["rotation"], step, seconds) for seconds in (QUICK, WHOLE))
        size, direction = _played(quick, whole)
        sizes, directions = zip(*(_played(*both) for both in zip(drawn(quick), drawn(whole), strict=True)), strict=True)
        turned = (np.array(directions) - direction + np.pi / 2) % np.pi - np.pi / 2
        return {"range": np.hypot(np.std(sizes), REACH * size), "direction": np.asarray(np.std(turned))}


class SpringyPlay(JointPlay):
    """The same on springs that its load pushes."""

    variant, scale = "springy", "share"
    law = "R2 = R1 Ry(q) exp(phi e), phi'' + 2 z w phi' + w^2 phi = -share e . (w' + arm x f)"
    states = (State("rotation", 1, 0.04),)
    parameters = (
        Parameter("frequency", (), "Hz", 0.7, start=5.0, log=True, reported=False),
        Parameter("damping_ratio", (), "1", 1.0, start=0.2, log=True, reported=False),
        Parameter("share", (), "1", 1.5, start=1.0, log=True, reported=False),
        Parameter("direction", (), "rad", 2.0),
        Parameter("arm", (3,), "1/m", 3.0, reported=False),
    )

    def grid(self, seconds: float) -> dict[str, Array]:
        return {"frequency": FREQUENCIES, "direction": DIRECTIONS[::2]}

    def read(self, values: Mapping[str, Array], states: Mapping[str, Array], step: float) -> dict[str, Array]:
        """What springs are within most of the time: where their load would push them beyond nobody has seen."""
        return {"range": np.asarray(np.quantile(np.abs(states["rotation"]), WITHIN), dtype=float)}

    def read_error(self, values: Mapping[str, Array], states: Mapping[str, Array], step: float) -> dict[str, Array]:
        """Of five plays of known range, 0.90 to 1.11 of it was reported."""
        return {"range": SPRUNG * self.read(values, states, step)["range"]}

    def equations(self, scene: Scene, p: Values) -> list[Equation]:
        phi, rate, accel = scene.own("rotation")
        segment = scene.segment.child(spin(1, *scene.turned()))
        load = dot(along(p["direction"]), segment.accel + cross(p["arm"], segment.force))
        w = 2 * np.pi * p["frequency"]
        pull = 2.0 * p["damping_ratio"] * w * rate + w * w * phi
        return [Equation("balance", accel + pull + p["share"] * load, 0.1)]

    def on_rig(self, rig: Rig, numbers: Numbers, weighed: bool) -> Rig:
        """Springs of which nothing beyond a range was seen have no stops there: these would come on top of the fit's.

        A share above 1 no inertia has: it is taken as 1.
        """
        if "frequency" not in numbers:
            return super().on_rig(rig, numbers, weighed)
        share = min(float(numbers.get("share", 1.0)), 1.0)
        frequency, ratio = float(numbers["frequency"]), float(numbers["damping_ratio"])
        play = Play(BEYOND * _reach(numbers), _direction(numbers), frequency, ratio, share)
        if weighed or "arm" not in numbers:
            return replace(rig, play=play)
        return replace(rig, play=play, segments=(*rig.segments[:-1], loose(rig.segments[-1], play, numbers["arm"])))


def _reach(numbers: Numbers) -> float:
    """Return a play's range in rad; MuJoCo has none of nothing."""
    return max(float(numbers.get("range", 0.0)), 1e-6)


def _direction(numbers: Numbers) -> float:
    return float(numbers.get("direction", 0.0))


def loose(segment: Segment, play: Play, arm: Array) -> Segment:
    """Return the segment whose play has the load -e . (w' + arm x f), in units of its inertia about e.

    With c across e and the same inertia I0 about every axis through the com, I0 + m c^2 = m k^2 about e, arm = c / k^2.
    What is of second order, e . (w x I w), is (c / k)^2 of that and not in the law: c / k is made small.
    """
    across = arm - play.axis * (play.axis @ arm)
    size = max(float(np.linalg.norm(across)), 1e-3)
    k = NARROW / size
    com = k**2 * across
    return Segment(segment.mass, com, np.full(3, segment.mass * (k**2 - com @ com)), segment.length)


def along(direction: Jet) -> Jet:
    """Return the axis (1, 3) of play in segment 2."""
    cos, sin = np.cos(direction.value), np.sin(direction.value)
    return direction.through(cos, -sin).at(X) + direction.through(sin, cos).at(Z)


def windows(states: Array, step: float, seconds: float) -> Array:
    """Return states (n, m) less their means in windows of some seconds that overlap by half, (windows, k, m)."""
    k = min(max(round(seconds / step), 2), len(states))
    cut = np.stack([states[i : i + k] for i in range(0, len(states) - k + 1, max(k // 2, 1))])
    return np.asarray(cut - cut.mean(axis=1, keepdims=True))


def drawn(windows: Array) -> Iterator[Array]:
    """Yield windows (k, ...) drawn from these again and again, the same ones in every call."""
    rng = np.random.default_rng(0)
    for _ in range(DRAWS):
        yield windows[rng.integers(0, len(windows), len(windows))]


def reached(rotations: Array) -> Array:
    """Return how far rotations (windows, k) reach to either side in nearly all of the windows."""
    return np.asarray(np.quantile(np.ptp(rotations, axis=1), REACHED) / 2, dtype=float)


def _played(quick: Array, whole: Array) -> tuple[Array, Array]:
    """Return the range of play and its direction from windows of its rotations."""
    axis = np.linalg.svd(np.einsum("kni,knj->ij", quick, quick))[0][:, 0]
    axis *= 1.0 if axis[0] >= 0 else -1.0
    return reached(whole @ axis), np.asarray(np.arctan2(axis[1], axis[0]))


EFFECTS: tuple[Effect, ...] = (JointPlay(), WobblyPlay(), SpringyPlay())
