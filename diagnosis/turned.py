"""A mount that is turned far from how it is declared: where the joint's axis is in its sensor, by gyroscopes alone.

Across a hinge's axis both of its gyroscopes turn equally fast. With w and v what the turned one and the other read, in
the axes of the segments as declared, y the axis there and j where it is in those of the turned one::

    |w x j|^2 = |v x y|^2,    so    w' (j j') w = |w|^2 - |v x y|^2

which is linear in j j': least squares, and the eigenvector of its largest eigenvalue, with either sign. The least turn
that takes j to y is where the fit begins anew, with its motion: begun as declared, mount and motion follow each other
to another minimum. A sensor that is turned by 1.6 rad was worth 1,108 nat so and a turn of pi at the other one 3,495;
begun anew it is worth 4,553. How far it is turned about the axis itself is one with the joint's angle.
"""

from contextlib import suppress
from dataclasses import replace

import numpy as np

from imubench import rotations
from imubench.arrays import Array
from imubench.diagnosis.blocks import NotPositiveDefiniteError
from imubench.diagnosis.clocks import late, on_segment
from imubench.diagnosis.fit import Fit
from imubench.diagnosis.hypothesis import Hypothesis, State
from imubench.diagnosis.kinematics import HINGE_AXIS
from imubench.diagnosis.model import Model
from imubench.diagnosis.nominal import begun
from imubench.diagnosis.refit import log_evidence, refit
from imubench.diagnosis.start import hinge_angle
from imubench.diagnosis.trial import POSE

AGREE = 0.25  # of a gyroscope's reading: where the two agree so well across the axis no mount is turned far
FAINT = 0.03  # of the strongest: a turn that is seen less is noise, as all are but one on a base that stands still
FAR = 0.35  # rad: what is turned by less is found from where it is declared
BETTER = 0.5  # of the cost of the start as declared, that one begun anew must have


def turned(fit: Fit, h: Hypothesis) -> Fit | None:
    """Return the fit with another pose of an IMU, begun anew where gyroscopes say that the axis is in it.

    None where they say that it is as declared, or nothing, or where that start is no better.
    """
    if h.effect.name != POSE or not fit.model.rig.hinge:
        return None
    model = fit.model.with_effects(())
    tries = []
    for turn in far_turns(model, h.at):
        mount = model.mounts[h.at]
        other = replace(mount, turn=mount.turn @ rotations.to_matrix(rotations.exp(turn)))
        with suppress(NotPositiveDefiniteError):
            tries.append((begun(replace(model, mounts=model.mounts | {h.at: other})), turn))
    if not tries:
        return None
    best, turn = min(tries, key=lambda t: t[0].cost)
    if best.cost > BETTER * begun(model).cost:
        return None
    with suppress(NotPositiveDefiniteError):
        return refit(moved_to(fit, best), (*fit.model.hypotheses, h), {h.key("rotation"): turn})
    return None


def best_begun(fit: Fit, h: Hypothesis, done: Fit) -> Fit:
    """Return the better of a refit with an effect, begun as declared, and one that is begun anew."""
    again = turned(fit, h)
    return again if again and log_evidence(again) > log_evidence(done) else done


def far_turns(model: Model, at: str) -> list[Array]:
    """Return the turns (3,) rad in the sensor's axes that take the joint's axis to where an IMU has it, if far ones."""
    imus = {i.name: i for i in model.recording.imus}
    if at not in imus or not (model.rig.turns or at == "imu2") or (model.rig.turns and len(imus) == 1):
        return []
    offsets, own = late(model), imus[at].time - model.start
    grid = own[(own > 0) & (own < min(i.time[-1] for i in imus.values()) - model.start)]
    both = {n: on_segment(model, i, grid, offsets.get(n, 0.0)) for n, i in imus.items()}
    if agreeing(model, grid, both):
        return []
    rate = both[at][0]
    across = [np.delete(w, HINGE_AXIS, axis=1) for n, (w, _) in both.items() if n != at and model.rig.turns]
    axis = axis_in(rate, np.sum(across[0] ** 2, axis=1) if across else np.zeros(len(rate)))
    turns = [_least_turn(sign * axis) for sign in (1, -1)]
    back = model.mounts[at].turn.T
    return [np.asarray(back @ t) for t in turns if np.linalg.norm(t) > FAR]


def agreeing(model: Model, grid: Array, both: dict[str, tuple[Array, Array]]) -> bool:
    """Return whether the gyroscopes of a hinge, as they are declared, agree across its axis."""
    second = both["imu2"][0]
    first = both["imu1"][0] if model.rig.turns else np.zeros_like(second)
    angle = hinge_angle(model, grid, both)
    c, s = np.cos(angle), np.sin(angle)
    gap = second[:, [0, 2]] - np.stack([c * first[:, 0] - s * first[:, 2], s * first[:, 0] + c * first[:, 2]], axis=1)
    return float(np.mean(np.sum(gap**2, axis=1))) < AGREE**2 * float(np.mean(np.sum(second**2, axis=1)))


def axis_in(rate: Array, across: Array) -> Array:
    """Return the axis (3,) across which rates (n, 3) rad/s turn by `across` (n,) (rad/s)^2, with any sign."""
    i, j = np.triu_indices(3)
    size = np.where(i == j, 1.0, np.sqrt(2.0))  # of the entries, so that the least of all solutions is the least matrix
    known = rate[:, i] * rate[:, j] * size
    outer = np.zeros((3, 3))
    outer[i, j] = np.linalg.lstsq(known, np.sum(rate**2, axis=1) - across, rcond=FAINT)[0] / size
    return np.asarray(np.linalg.eigh(outer, UPLO="U")[1][:, -1])


def _least_turn(axis: Array) -> Array:
    """Return the least turn (3,) rad that takes an axis to that of the joint."""
    joint = np.eye(3)[HINGE_AXIS]
    normal = np.cross(axis, joint)
    size = float(np.linalg.norm(normal))
    if size < 1e-9:  # against it: about any axis across
        return np.zeros(3) if axis @ joint > 0 else np.pi * np.eye(3)[HINGE_AXIS - 1]
    return np.asarray(normal / size * np.arctan2(size, axis @ joint))


def moved_to(fit: Fit, start: Fit) -> Fit:
    """Return a fit that goes on from the motion, mounts and clocks of a start, its own effects as they are."""
    coefficients = fit.state.coefficients.copy()
    for name in start.model.tracks.widths:
        coefficients[:, fit.model.tracks.columns(name)] = start.state.coefficients[:, start.model.tracks.columns(name)]
    values = {n: v for n, v in start.state.values.items() if n in fit.state.values}
    return replace(fit, state=State(coefficients, fit.state.values | values), anchor=start.anchor)


__all__ = ["best_begun", "turned"]
