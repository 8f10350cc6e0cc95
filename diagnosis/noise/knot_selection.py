"""A motion on fewer knots, where nothing that a recording shows needs as many, and on more, where springs ring.

With a knot for every sample a slow motion follows half of the noise, up to a frequency at which springs resound with
it: their numbers then lean on that noise as much as on what moves them, and its level comes out too small. On as few
knots as the motion needs neither is so.

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
from imubench.diagnosis.config.noise import COHERENCE, KNOT_SELECTION
from imubench.diagnosis.config.samples import NOISE_FLOOR
from imubench.diagnosis.config.solve import ALGEBRA, SOLVER
from imubench.diagnosis.noise.coherence import clear_at, clear_in
from imubench.diagnosis.noise.debias import law_parameters
from imubench.diagnosis.noise.noise_levels import levels
from imubench.diagnosis.problem.bspline import DEGREE, SUPPORT, Knots, Tracks
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import State
from imubench.diagnosis.problem.residuals import Rows
from imubench.diagnosis.solve.initialize import model_of
from imubench.diagnosis.solve.levenberg_marquardt import solve


def coarsest(fit: Fit) -> Fit:
    """Return the fit on as few knots as its recording needs, at the noise levels that it leaves there, or as it is."""
    finest = model_of(fit.model.recording).tracks.knots.step
    step, most = fit.model.tracks.knots.step, widest_spacing(fit)
    for times in (n for n in KNOT_SELECTION.fewer if KNOT_SELECTION.change * step < n * finest < most):
        if too_quick(fit, times * finest):
            continue
        other = coarser(fit, times * finest / step)
        if knots_suffice(other):
            return relevelled(other)
    return fit


def finer(fit: Fit) -> Fit:
    """Return the fit on so many knots that springs ring as they would, at the noise levels that it leaves there.

    A spline of three knots a period damps what it follows, and the damping ratios come out wrong.
    """
    times = widest_spacing(fit) / fit.model.tracks.knots.step
    return relevelled(coarser(fit, times)) if times < 1 / KNOT_SELECTION.change else fit


def widest_spacing(fit: Fit) -> float:
    """Return how many seconds knots may be apart for what rings on a fit's motion; inf where nothing does."""
    quickest = ringing(fit)
    return 1 / (KNOT_SELECTION.knots_per_period * quickest) if quickest else np.inf


def ringing(fit: Fit) -> float:
    """Return the frequency in Hz of the quickest springs that ring, 0 of none: those of which a motion is as quick.

    Springs of which one is quicker follow a slow motion with no life of their own, and knots for them only let in
    noise. How quick a motion is the gyroscope tells: a hum shakes an accelerometer at any frequency.
    """
    imus = {imu.name: imu for imu in fit.model.recording.imus}
    springs = [h for h in fit.model.hypotheses if h.at in imus and h.effect.lawful and not h.effect.filters]
    out = 0.0
    for h in springs:
        quick = [np.exp(fit.state.values[h.key(p.name)]) for p in h.effect.parameters if p.unit == "Hz"]
        most = max((float(f.max()) for f in quick), default=0.0)
        if KNOT_SELECTION.rung * most <= clear_in(fit, imus[h.at], "gyro"):
            out = max(out, min(most, COHERENCE.most_of_rate * imus[h.at].rate))
    return out


def relevelled(fit: Fit) -> Fit:
    """Return a fit at the noise levels that it leaves of the measurements."""
    found, _ = levels(fit)
    noise = fit.noise | {r.name: found[r.name] for r in fit.measured}
    return solve(fit.model, fit.state, noise, fit.anchor, steps=0)


def coarser(fit: Fit, times: float) -> Fit:
    """Return the fit solved on so many times fewer knots (more, below 1) at its noise levels, its laws' numbers kept.

    Without their pulls they would run off.
    """
    old = fit.model.tracks.knots
    knots = model_of(fit.model.recording, 1 / (times * old.step), fit.model.averaging).tracks.knots
    time = np.linspace(old.start + old.step / 2, old.start + old.step * (old.count - SUPPORT), 3 * old.count)
    time = time[(time > knots.start) & (time < knots.start + knots.step * (knots.count - DEGREE))]
    design, wanted = matrix(knots, time), matrix(old, time) @ fit.state.coefficients
    normal = (design.T @ design + ALGEBRA.half_digits * identity(knots.count)).tocsc()
    state = State(np.reshape(spsolve(normal, design.T @ wanted), (knots.count, -1)), fit.state.values)
    held = {name: state.values[name] for _, name, _ in law_parameters(fit)}
    model = replace(fit.model, tracks=Tracks(knots, fit.model.tracks.widths), tilts=None)
    still = replace(model, fixed=(model.fixed or {}) | held)
    found = solve(still, state, fit.noise, fit.anchor, enough=SOLVER.fine_gain)
    return solve(model, found.state, fit.noise, fit.anchor, steps=0)


def matrix(knots: Knots, time: Array) -> csr_array:
    """Return the matrix (n, knots) that makes values at times (n,) of a spline's coefficients."""
    places = knots.start + knots.step * (np.arange(knots.count + SUPPORT) - DEGREE)
    return BSpline.design_matrix(time, places, DEGREE)


def knots_suffice(fit: Fit) -> bool:
    """Return whether a fit's knots follow all that its recording shows; not where no IMU tells."""
    enough = bool(fit.model.recording.imus) and not too_quick(fit, fit.model.tracks.knots.step)
    return enough and all(peak <= NOISE_FLOOR.steady_power for peak in peaks(fit))


def too_quick(fit: Fit, spacing: float) -> bool:
    """Return whether a fit's motion is above the noise near the highest frequency that knots so many s apart follow.

    A motion that is so on many knots is so on fewer: nothing need be solved to know that these do not suffice.
    """
    most = KNOT_SELECTION.spared / (2 * spacing)
    return any(clear_at(fit, imu.name) > most for imu in fit.model.recording.imus)


def peaks(fit: Fit) -> Iterator[float]:
    """Yield by how much the loudest band of each IMU's residuals beyond the knots is above their topmost ones."""
    least = KNOT_SELECTION.unfollowed / (2 * fit.model.tracks.knots.step)
    imus = {imu.name for imu in fit.model.recording.imus}
    yield from (peak(rows, least) for rows in fit.measured if rows.name.split(".")[0] in imus)


def peak(rows: Rows, least: float) -> float:
    """Return that of one group from a frequency in Hz on; inf of so few samples that they have no spectrum there."""
    window = min(KNOT_SELECTION.window_samples, len(rows.time) // 4)
    if window < KNOT_SELECTION.bands:
        return np.inf
    rate = 1 / float(np.median(np.diff(rows.time)))
    f, power = welch(rows.whitened, rate, nperseg=window, axis=0)
    beyond = power[f >= least].sum(axis=1)
    if len(beyond) < KNOT_SELECTION.bands:
        return np.inf
    bands = [float(band.mean()) for band in np.array_split(beyond, KNOT_SELECTION.bands)]
    return max(bands) / float(np.mean(bands[-KNOT_SELECTION.bands // 4 :]))


__all__ = ["coarser", "coarsest", "finer"]
