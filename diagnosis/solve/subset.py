"""A fit of some seconds out of a longer one: where an effect with a life of its own is tried first."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from imubench.arrays import Array
from imubench.diagnosis.config.shared import STATISTICS
from imubench.diagnosis.config.solve import START
from imubench.diagnosis.problem.batch_model import middles
from imubench.diagnosis.problem.bspline import SUPPORT, Knots, Moment, Tracks
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import State
from imubench.diagnosis.problem.rig_kinematics import ATTITUDE
from imubench.diagnosis.solve.gauss_newton import all_rows
from imubench.jets import Jet
from imubench.recording import Recording


def loudest(fit: Fit, seconds: float) -> tuple[float, float]:
    """Return the window (start, end) s, on the splines' time, where most is left unexplained."""
    start, end = fit.span
    if end - start <= 1.5 * seconds:
        return start, end
    begins = np.arange(start, end - seconds, START.subset_hop_s)
    power = np.zeros(len(begins))
    for rows in fit.measured:
        sums = np.concatenate([[0.0], np.cumsum(np.minimum(rows.whitened**2, STATISTICS.rare_sigmas**2).sum(axis=1))])
        order = np.sort(rows.time)
        power += sums[np.searchsorted(order, begins + seconds)] - sums[np.searchsorted(order, begins)]
    best = float(begins[np.argmax(power)])
    return best, best + seconds


def excerpt(fit: Fit, start: float, end: float) -> Fit:
    """Return the fit of the samples between two times in s, counted as the splines do; its state as it was."""
    model = fit.model
    knots = model.tracks.knots
    inside = {name: _within(stamps, model.start, start, end) for name, stamps in model.stamps.items()}
    masks = None if model.masks is None else {name: mask[inside[name]] for name, mask in model.masks.items()}
    louder = None if model.louder is None else {name: times[inside[name]] for name, times in model.louder.items()}
    first = max(int((start - START.subset_margin_s - knots.start) / knots.step), 0)
    last = min(int((end + START.subset_margin_s - knots.start) / knots.step) + SUPPORT, knots.count)
    tracks = Tracks(Knots(knots.start + first * knots.step, knots.step, last - first), model.tracks.widths)
    recording = cut(model.recording, model.start + start, model.start + end)
    short = replace(model, recording=recording, tracks=tracks, masks=masks, louder=louder)
    state = State(fit.state.coefficients[first:last].copy(), fit.state.values)
    anchor = None
    if fit.anchor is not None:
        moment = Moment(tracks, state.coefficients, Jet(middles(short)[:1, None]))
        anchor = moment.track(ATTITUDE).value[0]
    rows = all_rows(short, state, fit.noise, anchor, fit.loose)
    return replace(fit, model=short, state=state, anchor=anchor, cost=sum(r.cost for r in rows), rows=rows)


def cut(recording: Recording, start: float, end: float) -> Recording:
    """Return the samples of a recording between two times in s."""

    def of(stamps: Array) -> NDArray[np.bool_]:
        return _within(stamps, 0.0, start, end)

    swings = [(max(a, start), min(b, end)) for a, b in recording.free_swings]
    return replace(
        recording,
        imus=tuple(
            replace(i, time=i.time[own], gyro=i.gyro[own], accel=i.accel[own])
            for i in recording.imus
            for own in [of(i.time)]
        ),
        encoders=tuple(replace(e, time=e.time[of(e.time)], angle=e.angle[of(e.time)]) for e in recording.encoders),
        poses=tuple(
            replace(
                p,
                time=p.time[own],
                position=None if p.position is None else p.position[own],
                quaternion=None if p.quaternion is None else p.quaternion[own],
            )
            for p in recording.poses
            for own in [of(p.time)]
        ),
        free_swings=tuple((a, b) for a, b in swings if b > a),
    )


def _within(stamps: Array, zero: float, start: float, end: float) -> NDArray[np.bool_]:
    return np.asarray((stamps - zero >= start) & (stamps - zero <= end), dtype=bool)
