"""How far physics outside the table is from the nearest name: what that leaves of its visibility.

Let d be the change of all readings by the physics and C those by a unit of each number of a named effect at the same
place, or at the joint; F the information of [d, C] with motion and geometry unknown (`sight`). Then

    beyond = min over names, over c of |d - C c| in F, square root

is a number of standard deviations: below about two no method tells the physics from that name, which is then what the
recording shows. F is that of the case's own noise, as if its colour were known; `least` is the least that any colour
leaves which a recording without a mismatch may have, for a diagnosis has only the residuals to tell it. Laws are taken
for straight in their numbers, filters at four cutoffs, slips at eight moments; a mount with hardening springs is held
against straight ones of its own frequency, damping and their neighbours.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from imubench.proof.options import COLOUR, CORNERS, Effect
from imubench.proof.played import Case
from imubench.proof.rotation import Array, Parameters
from imubench.proof.sight import Sight, sight

SMALL = 1e-4  # of a number, in its unit
SAME = 2.0  # standard deviations, within which a name is what the recording shows
FAINT = 1e-9  # relative: directions of C that nothing sees
IMU: dict[str, Parameters] = {
    **{f"{c}_{law}": {key: np.zeros(size)} for c in ("gyro", "accel") for law, key, size in (
        ("bias", "bias", 3), ("scale", "scale", 3), ("misalignment", "matrix", 6), ("drift", "rate", 3)
    )},
    "g_sensitivity": {"matrix": np.zeros((3, 3))},
    "mount_pose": {"rotation": np.zeros(3), "translation": np.zeros(3)},
    "skin_sliding": {"slide": np.zeros(3), "twist": np.zeros(3)},
    "time_offset": {"offset": 0.0},
    "clock_skew": {"skew": 0.0},
}  # fmt: skip
JOINT: dict[str, Parameters] = {"axis_coupling": {"coupling": np.zeros(2)}, "moving_centre": {"slide": np.zeros(3)}}
CUTOFFS = (8.0, 15.0, 30.0, 60.0)  # Hz
MOMENTS = 8  # at which a mount may have slipped
CLOCKS = ("time_offset", "clock_skew")
COLOURS = (CORNERS[0], (CORNERS[0] * CORNERS[1]) ** 0.5, CORNERS[1])  # Hz, corners of noise as coloured as may be
FEW = 3  # names that are held against the effect in such noise


def beyond(case: Case, seen: Sight | None = None) -> dict[str, Any] | None:
    """Return the `nearest` name to a case's one effect, how far `beyond` it that is, and which names are the `same`.

    `least`: how far beyond the nearest few it is in the least favourable noise. Names are "effect at place"; None in
    free swings, where the motion is not free.
    """
    seen = seen or sight(case)
    if seen is None or len(case.effects) != 1:
        return None
    told = _changes(case, seen)
    left = {name: min(_left(seen, change) for change in changes) for name, changes in told.items()}
    nearest = sorted(left, key=lambda n: left[n])
    few = [change for name in nearest[:FEW] for change in told[name]]
    noisy = (sight(replace(case, options=replace(case.options, colour=COLOUR, corner=c))) for c in COLOURS)
    least = min([left[nearest[0]], *(_left(view, change) for view in noisy if view for change in few)])
    same = sorted(name for name, x in left.items() if x < SAME)
    return {"nearest": nearest[0], "beyond": left[nearest[0]], "same": same, "least": least}


def _changes(case: Case, seen: Sight) -> dict[str, list[Array]]:
    """Return for each name what it has to explain of the effect (rows,) and then its own columns, each way it has."""
    (effect,) = case.effects
    plain, change = seen.readings([]), seen.readings([effect])
    names = {name: columns(seen, plain, start) for name, start in _candidates(case, effect).items()}
    names |= {f"low_pass at {effect.at}": np.stack([_filtered(seen, plain, effect.at, f) for f in CUTOFFS], axis=-1)}
    told = {name: [np.column_stack([change - plain, C])] for name, C in names.items()}
    slips = [columns(seen, plain, slip, tuple(IMU["mount_pose"])) for slip in _slips(case, effect)]
    told[f"mount_shift at {effect.at}"] = [np.column_stack([change - plain, C]) for C in slips]
    if effect.effect == "hardening_mount":
        straight = Effect("soft_mount", effect.at, {k: v for k, v in effect.parameters.items() if k != "span"})
        springs = seen.readings([straight])
        C = columns(seen, springs, straight, ("frequency", "damping_ratio"))
        told[f"soft_mount at {effect.at}"] = [np.column_stack([change - springs, C])]
    return told


def columns(seen: Sight, plain: Array, start: Effect, keys: tuple[str, ...] | None = None) -> Array:
    """Return the change of all readings (rows, k) by a unit of each number of an effect, from `plain` readings."""
    out = []
    for key in keys or tuple(start.parameters):
        value = np.asarray(start.parameters[key], dtype=float)
        for k in range(value.size):
            step = np.zeros(value.size)
            step[k] = SMALL * max(1.0, float(np.abs(value).max()))
            moved = value + step.reshape(value.shape)
            parameters = start.parameters | {key: moved if value.shape else float(moved)}
            out.append((seen.readings([replace(start, parameters=parameters)]) - plain) / step[k])
    return np.stack(out, axis=-1)


def _candidates(case: Case, effect: Effect) -> dict[str, Effect]:
    alone, joint = case.options.shape.ball, case.options.shape.hinge
    imu = {name: p for name, p in IMU.items() if not (alone and name in CLOCKS)}
    if not case.options.shape.jointed:
        del imu["skin_sliding"]
    at_imu = {f"{name} at {effect.at}": Effect(name, effect.at, p) for name, p in imu.items()}
    return at_imu | ({f"{name} at joint": Effect(name, "joint", p) for name, p in JOINT.items()} if joint else {})


def _slips(case: Case, effect: Effect) -> list[Effect]:
    times = case.options.seconds * (np.arange(MOMENTS) + 0.5) / MOMENTS
    return [Effect("mount_shift", effect.at, IMU["mount_pose"] | {"time": float(t)}) for t in times]


def _filtered(seen: Sight, plain: Array, at: str, cutoff: float) -> Array:
    return seen.readings([Effect("low_pass", at, {"cutoff": cutoff})]) - plain


def _left(seen: Sight, changes: Array) -> float:
    """Return what the columns behind the first one leave of that, in standard deviations."""
    F = seen.information(changes)
    d, C, g = F[0, 0], F[1:, 1:], F[1:, 0]
    scale = 1 / np.sqrt(np.maximum(np.diagonal(C), 1e-300))
    values, vectors = np.linalg.eigh(C * np.outer(scale, scale))
    told = (vectors.T @ (g * scale)) ** 2 / np.maximum(values, 1e-300)
    return float(np.sqrt(max(0.0, d - told[values > FAINT * values.max()].sum())))
