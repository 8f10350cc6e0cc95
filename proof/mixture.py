"""Many cases as a diagnosis would meet them: nothing wrong, one thing, several, something no table has.

Of every 100 cases 25 have no effect, 40 one, 20 two or three, 15 physics outside the table; 4 of the first two kinds
are such that the recording could not show it (the rig stands still, or hardly moves for a second). All of them have
the nuisances that a recording may have and that are no mismatch: geometry wrong by what is declared, noise declared
wrong by up to 15 % or not at all, up to 20 % of coloured noise, clocks and rates of their own, a gap, a repeated
sample, motion from slow to 10 Hz with rests.
"""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from imubench.proof.aimed import make_aimed
from imubench.proof.options import COLOUR, Options, stream
from imubench.proof.ranges import STRENGTHS, places
from imubench.proof.rigs import SHAPES
from imubench.proof.told import plain
from imubench.proof.unknown_ranges import unknown_places

SHARES = {"none": 0.25, "one": 0.40, "several": 0.20, "outside": 0.15}
UNOBSERVABLE = 0.04
LOUDER = {"gyro_noise", "accel_noise"}  # than declared
AIMED = {"one": (0.6, 1.0, 100.0), "several": (0.5, 10.0, 200.0), "outside": (0.5, 10.0, 200.0)}
"""The share of cases whose effects are so many times as large as their Cramer-Rao bound, log-uniform from, to."""
RIGS: dict[str, tuple[float, dict[str, Any]]] = {
    "hinge": (0.5, {"rig": "hinge"}),
    "fixed hinge": (0.07, {"rig": "hinge", "base": "fixed", "encoder": True}),
    "swinging hinge": (0.12, {"rig": "hinge", "base": "fixed", "swing": True}),
    "pendulum": (0.12, {"rig": "pendulum"}),
    "swinging pendulum": (0.07, {"rig": "pendulum", "swing": True}),
    "free": (0.12, {"rig": "free"}),
}
NEEDS_MOTION = (
    "gyro_scale", "gyro_misalignment", "time_offset", "clock_skew", "low_pass", "skin_sliding", "moving_centre",
    "axis_coupling", "soft_mount",
)  # fmt: skip
RIVALS = (  # of these at most one in a case: together they cannot be told apart, or one hides the other
    {"gravity", "accel_scale", "accel_bias"},
    {"soft_mount", "rocking_mount", "low_pass"},
    {"time_offset", "clock_skew", "low_pass"},
    {"moving_centre", "skin_sliding", "axis_coupling", "joint_play"},
    {"mount_pose", "mount_shift", "accel_misalignment", "gyro_misalignment"},
    {"saturation", "quantisation", "dropouts"},
    {"viscous_friction", "dry_friction", "air_drag"},
)


@dataclass(frozen=True)
class Question:
    """One case to be made: kind (none, one, several, outside), whether its motion can show anything, the rest."""

    kind: str
    observable: bool
    rig: str
    effects: list[tuple[str, str]]
    seed: int
    strength: str  # weak, medium, strong, for every effect without a wanted visibility
    wanted: list[float | None]  # one for each effect, times its Cramer-Rao bound
    options: dict[str, Any]


def mixture(seed: int, n: int) -> list[Question]:
    """Return n questions; the shares of the kinds are exact to one case."""
    kinds = [kind for kind, share in SHARES.items() for _ in range(round(share * n))]
    kinds = [*kinds, *["one"] * n][:n]
    rng = stream(seed, "mixture")
    blind = [i for i, kind in enumerate(kinds) if kind in ("none", "one")][:: round(1 / UNOBSERVABLE)]
    questions = [_question(kind, i not in blind, int(rng.integers(2**31)), rng) for i, kind in enumerate(kinds)]
    return [questions[i] for i in rng.permutation(n)]


def make(question: Question, out: Path) -> dict[str, Any]:
    """Write the recording of a question and return its truth."""
    q = question
    truth = make_aimed(out, q.rig, q.effects, q.seed, q.wanted, q.strength, **q.options)
    return truth | {"kind": question.kind, "observable": question.observable, "strength": question.strength}


def nuisances(rng: np.random.Generator) -> dict[str, Any]:
    """Return random options that are no mismatch."""
    rate, other = (float(rng.choice([50.0, 100.0, 100.0, 100.0, 128.0, 200.0])) for _ in range(2))
    return {
        "seconds": float(rng.uniform(40, 80)),
        "rate": rate,
        "rate2": rate if rng.random() < 0.7 else other,
        "band": float(np.exp(rng.uniform(0, np.log(10)))),
        "vigour": float(rng.uniform(0.5, 1.5)),
        "rest": float(rng.uniform(0, 0.35)),
        "gyro_noise": float(np.exp(rng.uniform(np.log(0.001), np.log(0.006)))),
        "accel_noise": float(np.exp(rng.uniform(np.log(0.01), np.log(0.05)))),
        "colour": float(rng.uniform(0, COLOUR) * (rng.random() < 0.5)),
        "misdeclared": float(rng.uniform(-0.15, 0.15)),
        "declare_noise": bool(rng.random() < 0.85),
        "position_std": float(rng.uniform(0.002, 0.006)),
        "rotation_std": float(rng.uniform(0.01, 0.04)),
        "declare_geometry": bool(rng.random() < 0.9),
        "gaps": int(rng.poisson(0.3)),
        "repeats": int(rng.poisson(0.3)),
    }


def _question(kind: str, observable: bool, seed: int, rng: np.random.Generator) -> Question:
    options = nuisances(rng)
    rig = str(rng.choice(list(RIGS), p=[share for share, _ in RIGS.values()]))
    if not observable:
        rig = "hinge" if rng.random() < 0.7 else "pendulum"
        short = {"seconds": float(rng.uniform(0.5, 1.5)), "vigour": 0.3, "gaps": 0, "repeats": 0}
        options |= {"rest": 1.0} if rng.random() < 0.5 else short
    options |= RIGS[rig][1]
    if SHAPES[options["rig"]].hinge:
        options["encoder"] = options.get("encoder", False) or bool(rng.random() < 0.3)
        options["pose"] = bool(rng.random() < 0.1)
    chosen = Options(**options)
    family = options.pop("rig")
    inside, outside = places(chosen), unknown_places(chosen)
    count = {"none": 0, "one": 1, "several": int(rng.integers(2, 4)), "outside": 0}[kind]
    if not observable:
        inside = {name: at for name, at in inside.items() if name in NEEDS_MOTION}
    effects = _picked(rng, inside, count)
    if kind == "outside":
        name = str(rng.choice(list(outside)))
        effects = [(name, str(rng.choice(list(outside[name]))))]
    if {name for name, _ in effects} & LOUDER:
        options["declare_noise"] = True  # louder than what? nobody could know
    strength = str(rng.choice(STRENGTHS, p=[0.25, 0.45, 0.3])) if observable else "weak"
    share, low, high = AIMED.get(kind, (0.0, 1.0, 1.0))
    aim = observable and rng.random() < share
    wanted = [float(np.exp(rng.uniform(np.log(low), np.log(high)))) if aim else None for _ in effects]
    if not observable and options["rest"] < 1:
        wanted = [1.0 for _ in effects]
    return Question(kind, observable, family, effects, seed, strength, wanted, options)


def _picked(rng: np.random.Generator, where: dict[str, tuple[str, ...]], count: int) -> list[tuple[str, str]]:
    """Return `count` different effects that are no rivals, each at a random one of its places."""
    picked: list[tuple[str, str]] = []
    names = list(where)
    while len(picked) < count:
        name = str(rng.choice(names))
        if not any(name == other or {name, other} <= rivals for other, _ in picked for rivals in RIVALS):
            picked.append((name, str(rng.choice(list(where[name])))))
    return picked


def listed(question: Question) -> dict[str, Any]:
    """Return a question as JSON can hold it."""
    return {key: plain(value) for key, value in asdict(question).items()}
