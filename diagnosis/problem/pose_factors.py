"""A measured pose whose errors wander: their rows, whitened.

A marker cluster's calibration, the cameras', and a maker's smoothing leave errors that last: what a pose is wrong by
now, it is wrong by a moment later. Taken for independent they outweigh a gyroscope at every frequency at which they are
larger than their mean, and come out as noise of the IMU. To first order such an error r of size s forgets itself at a
rate a (a Gauss-Markov process), and what is white is::

    r' + a r = u,    E[u u] = 2 a s^2 a second,

so samples that are `step` apart count as rows (r' + a r) sqrt(step / (2 a)) of standard deviation s. Far below a / (2
pi) Hz this is the pose as it stands, far above it is its velocity and its rate, and the IMU says where it moved.
Both are local: a row touches as many knots as before. With the measured attitude M and rate m, and R, w of the model::

    r = log(M' R),    r' = w - (M' R)' m          r = x - y,    r' = x' - y'
"""

from collections.abc import Iterator, Mapping

import numpy as np
from scipy.interpolate import make_interp_spline

from imubench import rotations
from imubench.arrays import Array
from imubench.diagnosis.config.solve import MOTION_PRIOR
from imubench.diagnosis.problem.bspline import DEGREE
from imubench.diagnosis.samples.pose_correlation import GaussMarkov
from imubench.jets import Jet, Turn
from imubench.links import Motion
from imubench.recording import Pose


def turn_error(measured: Array, turn: Turn) -> tuple[Jet, Turn]:
    """Return r (n, 3) rad of measured attitudes (n, 4), its derivative taken as that of M' R, and M' R."""
    error = Turn(np.swapaxes(rotations.to_matrix(measured), -1, -2)) @ turn
    return Jet(rotations.log(rotations.from_matrix(error.matrix)), dict(error.blocks)), error


def slopes(pose: Pose) -> dict[str, Array]:
    """Return the measured velocity (n, 3) m/s, world, and rate (n, 3) rad/s, body; NaN where few are near."""
    out = {}
    if pose.position is not None:
        out["position"] = _slope(pose.time, pose.position)[1]
    if pose.quaternion is not None:
        q = pose.quaternion.copy()
        seen = np.flatnonzero(np.isfinite(q).all(axis=1))
        flips = np.where(np.sum(q[seen[1:]] * q[seen[:-1]], axis=1) < 0, -1.0, 1.0)
        q[seen[1:]] *= np.cumprod(flips)[:, None]
        value, slope = _slope(pose.time, q)
        out["rotation"] = 2 * rotations.multiply(rotations.conjugate(value), slope)[:, 1:]
    return out


def _slope(time: Array, values: Array) -> tuple[Array, Array]:
    """Return values (n, k) and their derivative by a spline through what was seen."""
    seen = np.isfinite(values).all(axis=1)
    slope = np.full(values.shape, np.nan)
    if seen.sum() > DEGREE:
        near = (
            np.convolve(seen, np.ones(2 * MOTION_PRIOR.rate_neighbours + 1), "same") > 2 * MOTION_PRIOR.rate_neighbours
        )
        spline = make_interp_spline(time[seen], values[seen], k=DEGREE)
        slope[near] = spline(time[near], 1)
    return values, slope


def pose_errors(
    pose: Pose, segment: Motion, velocity: Jet | None, lasting: tuple[GaussMarkov, Mapping[str, Array]] | None
) -> Iterator[tuple[str, Jet, Array]]:
    """Yield "position" and "rotation", model minus measurement (n, 3), and the measurement; NaN does not count.

    `lasting`: how the errors last, and what `slopes` says of the pose; `velocity` (n, 3) m/s of the segment's origin.
    """
    if pose.position is not None and segment.position is not None:
        error, seen = segment.position - np.nan_to_num(pose.position), pose.position
        if lasting is not None and velocity is not None:
            wander, seen = lasting[0], lasting[1]["position"]
            error = wander.whitened(error, velocity - np.nan_to_num(seen))
        yield "position", error, seen
    if pose.quaternion is not None and segment.turn is not None:
        error, turn = turn_error(np.nan_to_num(pose.quaternion, nan=0.5), segment.turn)
        seen = pose.quaternion
        if lasting is not None:
            wander, seen = lasting[0], lasting[1]["rotation"]
            error = wander.whitened(error, segment.rate - turn.back(np.nan_to_num(seen)))
        yield "rotation", error, seen


__all__ = ["pose_errors", "slopes"]
