"""A stop that the swinging segment knocks against: every knock in a free swing begins at one hinge angle, the farthest.

A contact lasts milliseconds, and where the segment comes to rest against the stop it knocks too faintly to be heard:
neither a spline nor the equation of a free swing holds there. So the angle is read off where knocks begin, and what
lies beyond it is left out. With the contacts in the fit the spline swings too far, without them not far enough; the
angle lies between the two, its standard deviation half their difference.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation

from imubench.arrays import Array
from imubench.diagnosis.fit import Fit
from imubench.diagnosis.kinematics import HINGE
from imubench.diagnosis.result import Finding, Interval, Parameter
from imubench.diagnosis.samples import Sampled
from imubench.diagnosis.splines import Moment
from imubench.jets import Jet

STOP = "end_stop"
FEWEST = 2  # knocks that can agree
SAME = 0.02  # rad, how closely they do, as a median
BEYOND = 0.15  # rad that a smeared contact may seem to go beyond the stop
NEAR, PAD = 0.02, 0.02  # rad before the stop and s around it that are left out with it
FINE = 0.005  # s
LEAST_STD = 0.002  # rad
SURE = 0.95


@dataclass(frozen=True)
class Stop:
    """A stop and the parts of the recording in which the segment touches it."""

    angle: float  # rad
    std: float  # rad
    knocks: Array  # (k,) s
    windows: tuple[tuple[float, float], ...]  # s

    def masks(self, fit: Fit, known: dict[str, NDArray[np.bool_]]) -> dict[str, NDArray[np.bool_]]:
        """Return which samples count besides those in which the segment touches the stop."""
        out = dict(known)
        for name, stamps in fit.model.stamps.items():
            free = ~np.any([(stamps >= a) & (stamps <= b) for a, b in self.windows], axis=0)
            out[name] = known.get(name, np.ones(len(stamps), dtype=bool)) & free
        return out

    def swings(self, swings: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
        """Return free swings (start, end) s without the contacts."""
        out = list(swings)
        for a, b in self.windows:
            parts = [piece for start, end in out for piece in ((start, min(end, a)), (max(start, b), end))]
            out = [(start, end) for start, end in parts if end > start]
        return tuple(dict.fromkeys(out))

    def told(self, samples: Sampled) -> Sampled:
        """Return what the samples say, the stop in the place of its knocks."""
        angle = {"angle": Parameter(np.array(self.angle), np.array(self.std), "rad")}
        said = Finding(STOP, "joint", SURE, angle, Interval(0.0, (0.0, 0.0)))
        words = (
            f"{len(self.knocks)} knocks begin at a hinge angle of {self.angle:.3f} rad, the farthest that is reached."
        )
        return replace(samples, findings=(*samples.findings, said), unless_stopped=(), notes=(*samples.notes, words))


def stop_of(fit: Fit, samples: Sampled) -> Stop | None:
    """Return the stop that the knocks of free swings tell of; none where they begin anywhere."""
    if not samples.unless_stopped or not fit.model.rig.hinge:
        return None
    start = fit.model.start
    times = np.concatenate([np.atleast_1d(f.parameters["times"].value) for f in samples.unless_stopped])
    at = _angle(fit, times - start)
    angle = float(np.median(at))
    side = 1.0 if angle > 0 else -1.0
    first, last = fit.span
    fine = np.arange(first, last, FINE)
    inside = np.any([(fine + start >= a) & (fine + start <= b) for a, b in fit.model.recording.free_swings], axis=0)
    away = side * (_angle(fit, fine) - angle)
    if len(times) < FEWEST or np.median(np.abs(at - angle)) > SAME or away[inside].max() > BEYOND:
        return None
    touching = binary_dilation(inside & (away > -NEAR), iterations=round(PAD / FINE))
    edges = np.flatnonzero(np.diff(np.concatenate([[0], touching.astype(int), [0]])))
    ends = start + fine[np.minimum(edges, len(fine) - 1)]
    windows = tuple((float(a), float(b)) for a, b in zip(ends[::2], ends[1::2], strict=True))
    return Stop(angle, SAME, times, windows)


def settled_between(stop: Stop, without: Fit) -> Stop:
    """Return the stop with its angle between that of the fit with the contacts and of one without them."""
    other = float(np.median(_angle(without, stop.knocks - without.model.start)))
    return replace(stop, angle=(stop.angle + other) / 2, std=max(abs(stop.angle - other) / 2, LEAST_STD))


def _angle(fit: Fit, time: Array) -> Array:
    """Return the hinge angle (n,) rad at times (n,) s of the splines."""
    return Moment(fit.model.tracks, fit.state.coefficients, Jet(time[:, None])).track(HINGE).value[:, 0]
