"""A stop that the swinging segment knocks against: every knock in a free swing begins at one hinge angle, the farthest.

A contact lasts milliseconds, and where the segment comes to rest against the stop it knocks too faintly to be heard:
neither a spline nor the equation of a free swing holds there. So the angle is read off where knocks begin, and what
lies beyond it is left out. With the contacts in the fit the spline swings too far, without them not far enough; the
angle lies between the two, its standard deviation half their difference.

A pendulum's stop is at an angle of its swing about the world's y, and without a magnetometer no fit knows where y
points: it is the level axis about which the knocks agree best. The other way round along it the angle has the other
sign, and is the same stop. About an axis that it hardly swings about, all its angles lie close together, knocks or not:
there the angles agree without a stop.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation

from imubench.arrays import Array
from imubench.diagnosis.config.candidates import END_STOP
from imubench.diagnosis.config.shared import CONFIDENCE, EVIDENCE
from imubench.diagnosis.problem.bspline import Moment
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.rig_kinematics import HINGE
from imubench.diagnosis.result import Finding, Interval, Parameter
from imubench.diagnosis.samples.screening import SampleChecks
from imubench.diagnosis.windows import Window, covered, cut_out
from imubench.effects import EFFECTS
from imubench.jets import Jet

HEADINGS_RAD = np.linspace(0.0, 2 * np.pi, 180, endpoint=False)  # rad, of the axis that a pendulum swings about


@dataclass(frozen=True)
class Stop:
    """A stop and the parts of the recording in which the segment touches it."""

    angle: float  # rad
    std: float  # rad
    knocks: Array  # (k,) s
    windows: tuple[Window, ...]  # s
    heading: float = 0.0  # rad, of the axis that a pendulum's angle is about, from the fit's y
    least: float = END_STOP.least_std_rad  # rad, that its angle's standard deviation is at least

    def masks(self, fit: Fit, known: dict[str, NDArray[np.bool_]]) -> dict[str, NDArray[np.bool_]]:
        """Return which samples count besides those in which the segment touches the stop."""
        out = dict(known)
        for name, stamps in fit.model.stamps.items():
            free = ~covered(stamps, self.windows)
            out[name] = known.get(name, np.ones(len(stamps), dtype=bool)) & free
        return out

    def swings(self, swings: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
        """Return free swings (start, end) s without the contacts."""
        return cut_out(swings, self.windows)

    def told(self, samples: SampleChecks) -> SampleChecks:
        """Return what the samples say, the stop in the place of its knocks."""
        angle = {"angle": Parameter(np.array(self.angle), np.array(self.std), "rad")}
        name = EFFECTS.name_of(lambda e: e.stops_at)
        said = Finding(name, "joint", CONFIDENCE.repeated, angle, Interval(0.0, (0.0, 0.0)))
        words = f"{len(self.knocks)} contacts begin at a joint's angle of {self.angle:.3f} rad, the farthest reached."
        return replace(samples, findings=(*samples.findings, said), unless_stopped=(), notes=(*samples.notes, words))


def stop_of(fit: Fit, samples: SampleChecks) -> Stop | None:
    """Return the stop that the knocks of free swings tell of; none where they begin anywhere."""
    ball = fit.model.rig.ball
    if not samples.unless_stopped or not (fit.model.rig.hinge or ball):
        return None
    start = fit.model.start
    times = np.concatenate([np.atleast_1d(f.parameters["times"].value) for f in samples.unless_stopped])
    needed = 2 * EVIDENCE.events if ball else EVIDENCE.events  # as many choose the axis about which the others agree
    if len(times) < needed:
        return None
    knocks = times - start
    heading = _agreed(fit, knocks) if ball else 0.0
    at = angle_at(fit, knocks, heading)
    angle = float(np.median(at))
    side = 1.0 if angle > 0 else -1.0
    first, last = fit.span
    fine = np.arange(first, last, END_STOP.grid_s)
    free = covered(fine + start, fit.model.recording.free_swings)
    away = side * (angle_at(fit, fine, heading) - angle)
    since = fine - knocks[:, None]
    soon = np.any((since >= 0) & (since < END_STOP.soon_s), axis=0)
    swing = float(np.ptp(away[free]))
    apart = min(END_STOP.same_rad, END_STOP.same_share * swing)
    beyond = np.any(
        away[free] > np.where(soon, END_STOP.soon_rad, min(END_STOP.beyond_rad, END_STOP.beyond_share * swing))[free]
    )
    if beyond or np.median(np.abs(at - angle)) > apart:
        return None
    windows = left_out(fine + start, free & (away > -END_STOP.same_rad))
    return Stop(
        angle,
        END_STOP.same_rad,
        times,
        windows,
        heading,
        END_STOP.least_std_about_rad if ball else END_STOP.least_std_rad,
    )


def left_out(time: Array, touching: NDArray[np.bool_]) -> tuple[Window, ...]:
    """Return the stretches in s of evenly spaced times (n,) s in which a segment touches its stop, and beside them."""
    wide = binary_dilation(touching, iterations=round(END_STOP.pad_s / END_STOP.grid_s))
    edges = np.flatnonzero(np.diff(np.concatenate([[0], wide.astype(int), [0]])))
    ends = time[np.minimum(edges, len(time) - 1)]
    return tuple((float(a), float(b)) for a, b in zip(ends[::2], ends[1::2], strict=True))


def settled_between(stop: Stop, without: Fit) -> Stop:
    """Return the stop with its angle between that of the fit with the contacts and of one without them."""
    other = float(np.median(angle_at(without, stop.knocks - without.model.start, stop.heading)))
    return replace(stop, angle=(stop.angle + other) / 2, std=max(abs(stop.angle - other) / 2, stop.least))


def _agreed(fit: Fit, knocks: Array) -> float:
    """Return the heading in rad of the level axis about which a pendulum is at one angle, above 0, at every knock."""
    angles = swing_of(limb_at(fit, knocks), HEADINGS_RAD[:, None])
    middle = np.median(angles, axis=1)
    spread = np.where(middle > 0, np.median(np.abs(angles - middle[:, None]), axis=1), np.inf)
    return float(HEADINGS_RAD[int(np.argmin(spread))])


def angle_at(fit: Fit, time: Array, heading: float = 0.0) -> Array:
    """Return the angle (n,) rad at times (n,) s of the splines: a hinge's, or a pendulum's swing about a heading."""
    if fit.model.rig.hinge:
        return _moment(fit, time).track(HINGE).value[:, 0]
    return swing_of(limb_at(fit, time), heading)


def swing_of(limb: Array, heading: float | Array) -> Array:
    """Return the angle in rad of a limb's z axis in the world (3, n) about level axes of some headings in rad."""
    x, y, z = limb
    return np.asarray(np.arctan2(np.cos(heading) * x + np.sin(heading) * y, z))


def limb_at(fit: Fit, time: Array) -> Array:
    """Return where a pendulum's z axis points in the world (3, n) at times (n,) s of the splines."""
    return in_world(fit, time, np.array([[0.0, 0.0, 1.0]])).T


def in_world(fit: Fit, time: Array, vectors: Array) -> Array:
    """Return vectors (n, 3), or one (1, 3), of a pendulum's axes in the world's (n, 3), at times (n,) s of splines."""
    turn = fit.model.last(fit.state, _moment(fit, time)).turn
    assert turn is not None
    return np.asarray(turn.forth(Jet(vectors)).value)


def _moment(fit: Fit, time: Array) -> Moment:
    return Moment(fit.model.tracks, fit.state.coefficients, Jet(time[:, None]))
