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

Samples whose errors last were smoothed, by their maker or where they were brought to another rate. A window about each
sample with the variance 2 k in s^2 leaves of a motion, but for what is of fourth order in its width::

    M = R exp(k w'),    y = x + k x''

What trembles at 10 Hz is 5 % less behind a window of 5 ms, which would be a scale of the gyroscope, a filter, or a
mount that gives way. So k is a number of the fit, and its rows are of r + k w' and x + k x''.
How fast the segment's turning changes is the gyroscope's word, no spline's: its fourth derivative is not in the fit.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import make_interp_spline

from imubench import rotations
from imubench.arrays import Array
from imubench.diagnosis.config.shared import STATISTICS
from imubench.diagnosis.problem.bspline import DEGREE
from imubench.diagnosis.samples.pose_correlation import POSE_SPACING_S, GaussMarkov
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
        near = np.convolve(seen, np.ones(DEGREE), "same") >= DEGREE
        spline = make_interp_spline(time[seen], values[seen], k=DEGREE)
        slope[near] = spline(time[near], 1)
    return values, slope


def smoothing_std() -> float:
    """Return what k of a smoothed pose may be, in s^2: of a window as wide as samples may be counted once, at most."""
    return POSE_SPACING_S**2 / 24 / STATISTICS.clear_sigmas


@dataclass(frozen=True)
class Lasting:
    """What a pose was smoothed by, and how its errors last."""

    wander: GaussMarkov | None  # None: those of the samples that count do not last
    slopes: Mapping[str, Array]  # as `slopes` has them, where they last
    window: Jet  # (1, 1) s^2, k: half the variance of the window
    bends: tuple[Array, Array]  # (n, 3) rad/s^2 and rad/s^3, segment axes: how fast its rate changes, and that in turn

    def of_position(self, error: Jet, seen: Array, place: Callable[[int], Jet]) -> tuple[Jet, Array]:
        """Return the rows of x - y (n, 3) m, and the measurement that they need."""
        error = error + self.window * place(2)
        if self.wander is None:
            return error, seen
        seen = self.slopes["position"]
        change = place(1) - np.nan_to_num(seen) + self.window * place(3)
        return self.wander.whitened(error, change), seen

    def of_rotation(self, error: Jet, seen: Array, turn: Turn, rate: Jet) -> tuple[Jet, Array]:
        """Return the rows of log(M' R) (n, 3) rad, `turn` being M' R, and the measurement that they need."""
        error = error + self.window * self.bends[0]
        if self.wander is None:
            return error, seen
        seen = self.slopes["rotation"]
        change = rate - turn.back(np.nan_to_num(seen)) + self.window * self.bends[1]
        return self.wander.whitened(error, change), seen


def pose_errors(
    pose: Pose, segment: Motion, place: Callable[[int], Jet] | None, lasting: Lasting | None
) -> Iterator[tuple[str, Jet, Array]]:
    """Yield "position" and "rotation", model minus measurement (n, 3), and the measurement; NaN does not count.

    Args:
        pose: the samples that are asked.
        segment: its motion there.
        place: the derivative (n, 3) of some order of its position there, m/s^order; None where no spline has it.
        lasting: what they were smoothed by; None: by nothing.
    """
    if pose.position is not None and segment.position is not None:
        error, seen = segment.position - np.nan_to_num(pose.position), pose.position
        if lasting is not None and place is not None:
            error, seen = lasting.of_position(error, seen, place)
        yield "position", error, seen
    if pose.quaternion is not None and segment.turn is not None:
        error, turn = turn_error(np.nan_to_num(pose.quaternion, nan=0.5), segment.turn)
        seen = pose.quaternion
        if lasting is not None:
            error, seen = lasting.of_rotation(error, seen, turn, segment.rate)
        yield "rotation", error, seen


__all__ = ["Lasting", "pose_errors", "slopes", "smoothing_std"]
