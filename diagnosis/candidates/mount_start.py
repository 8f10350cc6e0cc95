"""A mount that is turned far from how it is declared: where the joint's axis is in its sensor, by gyroscopes alone.

Across a hinge's axis both of its gyroscopes turn equally fast. With w and v what the turned one and the other read, in
the axes of the segments as declared, y the axis there and j where it is in those of the turned one::

    |w x j|^2 = |v x y|^2,    so    w' (j j') w = |w|^2 - |v x y|^2

which is linear in j j': least squares, and the eigenvector of its largest eigenvalue, with either sign. The least turn
that takes j to y is where the fit begins anew, with its motion: begun as declared, mount and motion follow each other
to another minimum. How far it is turned about the axis itself is one with the joint's angle.
"""

from contextlib import suppress
from dataclasses import replace

import numpy as np

from imubench import rotations
from imubench.arrays import Array
from imubench.diagnosis.candidates.mount_lever_arm import far_lever_arm
from imubench.diagnosis.config.candidates import MOUNT_START
from imubench.diagnosis.noise.nominal import first_fit
from imubench.diagnosis.problem.batch_model import Model
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis, State
from imubench.diagnosis.problem.rig_kinematics import HINGE_AXIS
from imubench.diagnosis.solve.block_tridiagonal import NotPositiveDefiniteError
from imubench.diagnosis.solve.clock_offsets import late, on_segments
from imubench.diagnosis.solve.initialize import hinge_angle, least_turn
from imubench.diagnosis.solve.refit import log_evidence, refit

JOINT_AXIS = np.eye(3)[HINGE_AXIS]


def with_turned_mount(fit: Fit, h: Hypothesis) -> Fit | None:
    """Return the fit with another pose of an IMU, begun anew where gyroscopes say that the axis is in it.

    None where they say that it is as declared, or nothing, or where that start is no better.
    """
    if not h.effect.misplaces or not fit.model.rig.hinge:
        return None
    model = fit.model.with_effects(())
    tries = []
    for turn in far_turns(model, h.at):
        arm = far_lever_arm(placed(model, h.at, turn, np.zeros(3)), h.at)
        for way in (np.zeros(3), arm) if arm is not None else (np.zeros(3),):
            with suppress(NotPositiveDefiniteError):
                tries.append((first_fit(placed(model, h.at, turn, way)), turn, way))
    if not tries:
        return None
    best, turn, way = min(tries, key=lambda t: t[0].cost)
    if best.cost > MOUNT_START.better * first_fit(model).cost:
        return None
    with suppress(NotPositiveDefiniteError):
        start = {h.key("rotation"): turn, h.key("translation"): way}
        return refit(moved_to(fit, best), (*fit.model.hypotheses, h), start)
    return None


def placed(model: Model, at: str, turn: Array, way: Array) -> Model:
    """Return the model with a mount turned by (3,) rad in its own axes and moved by (3,) m in the segment's."""
    mount = model.mounts[at]
    other = replace(mount, turn=mount.turn @ rotations.to_matrix(rotations.exp(turn)), position=mount.position + way)
    return replace(model, mounts=model.mounts | {at: other})


def better_start(fit: Fit, h: Hypothesis, done: Fit) -> Fit:
    """Return the better of a refit with an effect, begun as declared, and one that is begun anew."""
    again = with_turned_mount(fit, h)
    return again if again and log_evidence(again) > log_evidence(done) else done


def far_turns(model: Model, at: str) -> list[Array]:
    """Return the turns (3,) rad in the sensor's axes that take the joint's axis to where an IMU has it, if far ones."""
    imus = {i.name: i for i in model.recording.imus}
    if model.rig.tree.pair is None:
        return []
    one, two = model.rig.tree.pair
    needed = {one, two} if model.rig.turns else {two}
    if at not in needed or not needed <= imus.keys():
        return []
    own = imus[at].time - model.start
    grid = own[(own > 0) & (own < min(i.time[-1] for i in imus.values()) - model.start)]
    read = on_segments(model, grid, late(model))
    rates = {n: rate for n, (rate, _) in read.items()}
    if not model.rig.turns:
        rates[one] = np.zeros_like(rates[two])
    if agreeing(rates[one], rates[two], hinge_angle(model, grid, read)):
        return []
    other = rates[two if at == one else one]
    axis = axis_in(rates[at], np.sum(np.delete(other, HINGE_AXIS, axis=1) ** 2, axis=1))
    turns = rotations.log(least_turn(np.stack([axis, -axis]), JOINT_AXIS))
    return [np.asarray(model.mounts[at].turn.T @ t) for t in turns if np.linalg.norm(t) > MOUNT_START.far_rad]


def agreeing(first: Array, second: Array, angle: Array) -> bool:
    """Return whether two gyroscopes' rates (n, 3) rad/s on a hinge at angles (n,) rad agree across its axis."""
    turned_on = rotations.rotate_back(rotations.from_axis_angle(JOINT_AXIS, angle), first)
    gap = np.delete(second - turned_on, HINGE_AXIS, axis=1)
    return bool(np.sum(gap**2) < MOUNT_START.agree**2 * np.sum(second**2))


def axis_in(rate: Array, across: Array) -> Array:
    """Return the axis (3,) across which rates (n, 3) rad/s turn by `across` (n,) (rad/s)^2, with any sign."""
    i, j = np.triu_indices(3)
    size = np.where(i == j, 1.0, np.sqrt(2.0))  # of the entries, so that the least of all solutions is the least matrix
    known = rate[:, i] * rate[:, j] * size
    outer = np.zeros((3, 3))
    outer[i, j] = np.linalg.lstsq(known, np.sum(rate**2, axis=1) - across, rcond=MOUNT_START.faint)[0] / size
    return np.asarray(np.linalg.eigh(outer, UPLO="U")[1][:, -1])


def moved_to(fit: Fit, start: Fit) -> Fit:
    """Return a fit that goes on from the motion, mounts and clocks of a start, its own effects as they are."""
    coefficients = fit.state.coefficients.copy()
    for name in start.model.tracks.widths:
        coefficients[:, fit.model.tracks.columns(name)] = start.state.coefficients[:, start.model.tracks.columns(name)]
    values = {n: v for n, v in start.state.values.items() if n in fit.state.values}
    return replace(fit, state=State(coefficients, fit.state.values | values), anchor=start.anchor)


__all__ = ["better_start", "with_turned_mount"]
