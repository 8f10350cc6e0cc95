"""By how much two fits of one recording differ in what a user asks for, and by how much worse the one answer is.

At times t_k spread over the recording, in s of the world. Of a fit, R_i(t) and p_i(t) are the pose of IMU i on its
segment (sensor -> segment, m), S_j(t) segment j in the world, J(t) and d(t) segment 2 on segment 1, q(t) the hinge
angle; effects on mounts and at the joint are in all of these. Then

    axis of the hinge in sensor axes    a_1 = R_1^T e_y,  a_2 = R_2^T J^T e_y
    joint centre in sensor axes         c_1 = R_1^T (d - p_1),  c_2 = -R_2^T p_2
    up in segment axes                  u_j = S_j^T e_z

With ' for the other fit and rms over the t_k::

    joint_axis            rms angle(a_i, a_i')                                 deg, by IMU
    joint_centre          rms |A_i (c_i - c_i')|,  A_i = 1 - a_i a_i^T         mm, by IMU
    hinge_angle           rms (q - q' - m),  m the circular mean of q - q'     deg RMS
    hinge_angle_constant  |m|                                                  deg
    orientation           rms angle(u_j, u_j')                                 deg RMS, by segment

Of a hinge any point on its axis is a centre, and nothing tells them apart: both sensors a little farther along it read
the same. A pendulum has one centre, A_i = 1, and no axis. A free body has no centre either, but its pose may be
measured: `mount_rotation` is rms angle(R_i^T R_i') in deg, `lever` rms |p_i - p_i'| in mm.

Nothing measures a heading without a magnetometer, so an orientation's is left out; beside a measured orientation, or on
a base that stands still, `orientation` is rms angle(S_j^T S_j') instead.

How uncertain an answer is: the fit's posterior is Gaussian about its state, its covariance the inverse of the normal
equations. With N = L L' of the splines, B their border and S the Schur complement of the shared numbers p,

    p ~ N(0, S^-1),    x = -N^-1 B p + L'^-1 z,    z white

With W W' = S^-1 and the squares of what `moves_between` says of a state beside the fit's, s^2 is the sum over the
columns of W (p = w) and the mean over some draws of z (p = 0). The noise is taken for white, so s is rather too small.

Let s be the standard deviation of an answer with a finding in the fit, s_o without it, and d the shift between both.
The finding's numbers are estimates themselves, so d holds their chance, too: E d^2 = D^2 + (s^2 - s_o^2), with D what
the finding does and, of two efficient estimates, the variance of their difference (Hausman, Econometrica 46, 1251).
The mean square error of the answer is s^2 with the finding, s_o^2 + D^2 without it, and so the answer is

    sqrt(d^2 + 2 s_o^2 - s^2) - s

farther off without it, or not at all where that is negative: by d where the answer is exact, by nothing where the
finding's numbers are too uncertain to make it any better. A model with fewer numbers knows its answers no worse; where
it seems to, by another linearisation, s_o counts as s.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from imubench.arrays import Array, rms
from imubench.diagnosis.config.noise import DEBIAS
from imubench.diagnosis.config.shared import STATISTICS
from imubench.diagnosis.config.verdict import SHIFT
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import State
from imubench.diagnosis.problem.motion_prior import TILT
from imubench.diagnosis.problem.rig_kinematics import HINGE, HINGE_AXIS
from imubench.diagnosis.remembered import kept_with
from imubench.diagnosis.result import Move
from imubench.diagnosis.solve.block_tridiagonal import NotPositiveDefiniteError
from imubench.diagnosis.solve.bordered import Solution
from imubench.diagnosis.solve.gauss_newton import factored
from imubench.diagnosis.solve.marginals import covariance_of, root
from imubench.diagnosis.solve.retract import moved
from imubench.diagnosis.solve.threads import one_thread
from imubench.diagnosis.verdict.reference_motion import angle_difference, mean_angle
from imubench.recording import Recording
from imubench.rotations import angle_between

DEG_PER_RAD, MM_PER_M = 180 / np.pi, 1e3


@dataclass(frozen=True)
class Estimates:
    """What a user asks of a fit, at some times; rotations (n, 3, 3), vectors (n, 3)."""

    mounts: list[tuple[Array, Array]]  # by IMU: sensor -> segment, and its place in the segment in m
    axes: list[Array]  # by IMU: the hinge's axis in sensor axes
    centres: list[Array]  # by IMU: from the sensor to the joint centre in m, sensor axes
    segments: list[Array]  # by segment: segment -> world
    angle: Array | None  # (n,) rad, hinge angle

    def placed_as(self, other: "Estimates") -> "Estimates":
        """Return this motion with another's sensors on its segments."""
        return replace(self, mounts=other.mounts, axes=other.axes, centres=other.centres)


def times(fit: Fit) -> Array:
    """Return times (n,) s, as stamped, that are spread over what a fit has measured."""
    first, last = fit.span
    return np.asarray(fit.model.start + np.linspace(first, last, min(fit.model.tracks.knots.count, SHIFT.most_times)))


def estimates_of(fit: Fit, time: Array) -> Estimates:
    """Return what a fit says of its rig at times (n,) s."""
    model, state, n = fit.model, fit.state, len(time)
    moment = model.moment(state, time, "")
    motions = model.segments(state, moment)
    link = model.joint_link(state, moment, motions[model.rig.tree.names[0]])
    across = np.broadcast_to(np.eye(3)[HINGE_AXIS], (n, 3))
    mounts, axes, centres = [], [], []
    for imu in model.recording.imus:
        segment = model.recording.carrier(imu.name)
        mount = model.mount(imu, state, moment, motions[segment])
        turn = np.broadcast_to(mount.turn.matrix, (n, 3, 3))
        place = np.broadcast_to(mount.offset.value, (n, 3))
        mounts.append((turn, place))
        first = segment != model.rig.tree.last.name
        centre = link.offset.value if first else np.zeros((1, 3))
        axis = across if first else back(np.broadcast_to(link.turn.matrix, (n, 3, 3)), across)
        axes.append(back(turn, axis))
        centres.append(back(turn, centre - place))
    turns = [m.turn.matrix for m in motions.values() if m.turn is not None]
    angle = moment.track(HINGE).value[:, 0] if model.rig.hinge else None
    return Estimates(mounts, axes, centres, [np.broadcast_to(t, (n, 3, 3)) for t in turns], angle)


def moves_between(one: Estimates, other: Estimates, recording: Recording) -> dict[str, Move]:
    """Return by how much two fits of a recording differ in what its rig can be asked for."""
    out: dict[str, Move] = {}
    pairs = list(zip(one.mounts, other.mounts, strict=True))
    if pairs and recording.tree.hinge is not None:
        out["joint_axis"] = Move(_each(angle_between, one.axes, other.axes) * DEG_PER_RAD, "deg")
    if pairs and recording.tree.loose:
        out["mount_rotation"] = Move(np.array([rms(turned(a[0], b[0])) for a, b in pairs]) * DEG_PER_RAD, "deg")
        out["lever"] = Move(np.array([rms(norm(a[1] - b[1])) for a, b in pairs]) * MM_PER_M, "mm")
    elif pairs:
        between = [a - b for a, b in zip(one.centres, other.centres, strict=True)]
        if recording.tree.hinge is not None:
            between = [x - a * np.sum(a * x, axis=1, keepdims=True) for x, a in zip(between, one.axes, strict=True)]
        out["joint_centre"] = Move(np.array([rms(norm(x)) for x in between]) * MM_PER_M, "mm")
    if one.angle is not None and other.angle is not None:
        off = angle_difference(one.angle, other.angle)
        mean = mean_angle(off)
        out["hinge_angle"] = Move(np.array(rms(angle_difference(off, mean)) * DEG_PER_RAD), "deg RMS")
        out["hinge_angle_constant"] = Move(np.array(abs(mean) * DEG_PER_RAD), "deg")
    differing = turned if heading_known(recording) else tilted
    out["orientation"] = Move(_each(differing, one.segments, other.segments) * DEG_PER_RAD, "deg RMS")
    return out


def heading_known(recording: Recording) -> bool:
    """Return whether anything says where a segment heads."""
    return recording.clamped or any(pose.quaternion is not None for pose in recording.poses)


def _each(differing, ones: list[Array], others: list[Array]) -> Array:  # type: ignore[no-untyped-def]
    return np.array([rms(differing(a, b)) for a, b in zip(ones, others, strict=True)])


def back(turn: Array, vector: Array) -> Array:
    """Return R^T v (n, 3) of rotations (n, 3, 3) and vectors (n, 3)."""
    return np.asarray(np.einsum("nji,nj->ni", turn, vector))


def turned(a: Array, b: Array) -> Array:
    """Return the angles (n,) rad of the rotations between two (n, 3, 3)."""
    across = np.einsum("nji,njk->nik", a, b)
    skew = np.stack([across[:, 2, 1] - across[:, 1, 2], across[:, 0, 2] - across[:, 2, 0],
                     across[:, 1, 0] - across[:, 0, 1]], axis=1)  # fmt: skip
    return np.asarray(np.arctan2(norm(skew), np.trace(across, axis1=1, axis2=2) - 1))


def tilted(a: Array, b: Array) -> Array:
    """Return the angles (n,) rad by which up differs in two frames (n, 3, 3) -> world."""
    return angle_between(a[:, 2], b[:, 2])


def norm(x: Array) -> Array:
    """Return the lengths (n,) of vectors (n, 3)."""
    return np.asarray(np.linalg.norm(x, axis=1))


Spread = Mapping[str, Array]
"""Standard deviations of what a user asks for, by its name, in the unit and shape of the moves of that name."""


@kept_with
@one_thread
def spread_of(fit: Fit) -> Spread:
    """Return the standard deviations of what a user asks for; empty where not all of the motion is held.

    What findings move alone, and together, and what doubts matter asks for them.
    """
    time = times(fit)
    here = estimates_of(fit, time)
    squares: dict[str, Array] = {}
    try:
        _, solution, _ = factored(fit.model, [r for r in fit.rows if not r.name.startswith(TILT)])
    except NotPositiveDefiniteError:
        return {}
    for share, state in (*by_numbers(fit, solution), *by_splines(fit, solution)):
        there = estimates_of(replace(fit, state=state), time)
        for name, move in moves_between(here, there, fit.model.recording).items():
            squares[name] = squares.get(name, 0.0) + share * move.value**2
    return {name: np.sqrt(square) for name, square in squares.items()}


def by_numbers(fit: Fit, solution: Solution) -> Iterator[tuple[float, State]]:
    """Yield states one standard deviation of the shared numbers away, along every axis of their covariance."""
    wide = root(covariance_of(fit.model, solution.schur))
    splines = solution.factor.backward(-(solution.half @ wide))
    yield from ((1.0, moved(fit.model, fit.state, splines[:, :, i], wide[:, i])) for i in range(wide.shape[1]))


def by_splines(fit: Fit, solution: Solution) -> Iterator[tuple[float, State]]:
    """Yield states with drawn splines, the shared numbers as they are, and the share of each."""
    blocks, b, p = solution.border.shape
    draws = np.random.default_rng(STATISTICS.seed).standard_normal((DEBIAS.draws, blocks, b))
    splines = solution.factor.backward(np.moveaxis(draws, 0, 2))
    yield from (
        (1 / DEBIAS.draws, moved(fit.model, fit.state, splines[:, :, i], np.zeros(p))) for i in range(DEBIAS.draws)
    )


def farther_off(moves: Mapping[str, Move], spread: Spread, without: Spread | None = None) -> dict[str, Move]:
    """Return by how much farther off what a user asks for is for shifts.

    Args:
        moves: the shifts.
        spread: standard deviations of the answers that are shifted from.
        without: those of the answers that are shifted to; None: the same, for none of these numbers is estimated.
    """
    out = {}
    for name, move in moves.items():
        std = spread.get(name, np.zeros(()))
        other = np.minimum(std if without is None else without.get(name, std), std)
        out[name] = Move(np.sqrt(np.maximum(move.value**2 + 2 * other**2 - std**2, std**2)) - std, move.unit)
    return out


__all__ = ["Estimates", "Spread", "estimates_of", "farther_off", "moves_between", "spread_of", "times"]
