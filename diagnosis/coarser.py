"""A motion on fewer knots, where nothing that a recording shows needs as many: what a search begins with.

With a knot for every sample a slow motion follows half of the noise, up to a frequency at which springs resound with
it: their numbers then lean on that noise as much as on what moves them, and its level comes out too small (that of one
accelerometer by 29 %). Of the numbers of three mounts in a blind run, worth 22 to 30 bounds and moved at up to 2.2 Hz,
19 of 36 were in their 95 % interval so, and 28 with a third or a quarter of the knots.

A knot less is one too few where the motion, or what rings on it, is above the noise near the highest frequency that
the knots can follow, or where what they cannot follow is left: white noise leaves a flat spectrum beyond. Slow noise,
and what a sensor reads wrongly of a slow motion, few knots follow as many would.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from scipy.interpolate import BSpline
from scipy.signal import welch
from scipy.sparse import csr_array, identity
from scipy.sparse.linalg import spsolve

from imubench.arrays import Array
from imubench.diagnosis.coherence import clear_at
from imubench.diagnosis.fit import Fit, solve
from imubench.diagnosis.hypothesis import State
from imubench.diagnosis.noise import FINE, levels
from imubench.diagnosis.rows import Rows
from imubench.diagnosis.splines import DEGREE, SUPPORT, Knots, Tracks
from imubench.diagnosis.start import model_of
from imubench.diagnosis.tilt import lawful

TIMES = (4, 3, 2)  # fewer knots, the fewest first
SPARED = 0.45  # of the highest frequency of the knots: above, nothing may be more than noise
BANDS, FLAT = 6, 1.25  # of a residual's spectrum, and how far above the topmost any may be
BEYOND = 0.7  # of the highest frequency of the knots: from there on they do not follow a residual
MORE = 1.1  # times as far apart as the knots are: less is no change
STEPS = 15  # of the solver, to where fewer knots lead
WINDOW = 256  # samples of which a spectrum is taken
TINY = 1e-9  # of a coefficient's weight, for those that no time asks for


def coarsest(fit: Fit) -> Fit:
    """Return the fit on as few knots as its recording needs, at the noise levels that it leaves there, or as it is."""
    finest = model_of(fit.model.recording).tracks.knots.step
    for times in (n for n in TIMES if n * finest > MORE * fit.model.tracks.knots.step):
        other = coarser(fit, times * finest / fit.model.tracks.knots.step)
        if enough(other):
            found, _ = levels(other)
            noise = other.noise | {r.name: found[r.name] for r in other.measured}
            return solve(other.model, other.state, noise, other.anchor, steps=0)
    return fit


def coarser(fit: Fit, times: float) -> Fit:
    """Return the fit solved on so many times fewer knots at its noise levels, the numbers of its laws as they were.

    Without their pulls they would run off: a damping ratio to 9,800.
    """
    old = fit.model.tracks.knots
    knots = model_of(fit.model.recording, 1 / (times * old.step)).tracks.knots
    time = np.linspace(old.start + old.step / 2, old.start + old.step * (old.count - SUPPORT), 3 * old.count)
    design, wanted = matrix(knots, time), matrix(old, time) @ fit.state.coefficients
    normal = (design.T @ design + TINY * identity(knots.count)).tocsc()
    state = State(np.reshape(spsolve(normal, design.T @ wanted), (knots.count, -1)), fit.state.values)
    held = {name: state.values[name] for _, name, _ in lawful(fit)}
    model = replace(fit.model, tracks=Tracks(knots, fit.model.tracks.widths), tilts=None)
    still = replace(model, fixed=(model.fixed or {}) | held)
    found = solve(still, state, fit.noise, fit.anchor, steps=STEPS, enough=FINE)
    return solve(model, found.state, fit.noise, fit.anchor, steps=0)


def matrix(knots: Knots, time: Array) -> csr_array:
    """Return the matrix (n, knots) that makes values at times (n,) of a spline's coefficients."""
    places = knots.start + knots.step * (np.arange(knots.count + SUPPORT) - DEGREE)
    return BSpline.design_matrix(time, places, DEGREE)


def enough(fit: Fit) -> bool:
    """Return whether a fit's knots follow all that its recording shows; not where no IMU tells."""
    imus = fit.model.recording.imus
    most = SPARED / (2 * fit.model.tracks.knots.step)
    quick = any(clear_at(fit, imu.name) > most for imu in imus)
    return bool(imus) and not quick and all(peak <= FLAT for peak in peaks(fit))


def peaks(fit: Fit) -> Iterator[float]:
    """Yield by how much the loudest band of each IMU's residuals beyond the knots is above their topmost ones."""
    least = BEYOND / (2 * fit.model.tracks.knots.step)
    imus = {imu.name for imu in fit.model.recording.imus}
    yield from (peak(rows, least) for rows in fit.measured if rows.name.split(".")[0] in imus)


def peak(rows: Rows, least: float) -> float:
    """Return that of one group from a frequency in Hz on; inf of so few samples that they have no spectrum there."""
    window = min(WINDOW, len(rows.time) // 4)
    if window < BANDS:
        return np.inf
    rate = 1 / float(np.median(np.diff(rows.time)))
    f, power = welch(rows.whitened, rate, nperseg=window, axis=0)
    beyond = power[f >= least].sum(axis=1)
    if len(beyond) < BANDS:
        return np.inf
    bands = [float(band.mean()) for band in np.array_split(beyond, BANDS)]
    return max(bands) / float(np.mean(bands[-BANDS // 4 :]))


__all__ = ["coarser", "coarsest"]
