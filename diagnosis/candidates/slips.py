"""When a mount slipped: what a slip at each of many moments would explain, motion and geometry free to follow."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.criteria.onset_scan import After
from imubench.diagnosis.problem.batch_model import started
from imubench.diagnosis.problem.bspline import Tracks
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.problem.residuals import Parameters, Rows
from imubench.diagnosis.solve.linearize import linearise
from imubench.diagnosis.solve.schur import Base
from imubench.effects.mounts import SLIP
from imubench.jets import derivatives_by

APART = (2.0, 0.3, 0.1, 0.05)  # s between the moments of a slip that are compared, closer and closer
AROUND = 2  # of these to either side are looked at anew: a peak is as narrow as a slip is short
COARSE = 60  # moments of a long recording, first
AT_PEAK, PEAKS = 0.05, 3  # s between moments about the loudest, and how many to either side
PARTS = 4  # of a slip, at which the loudest stretch may begin
CLEAR = 1.25  # times as long as a slip lasts, from one to the next
BEFORE = np.array([-1e9])  # s: it has slipped long since


def slip(base: Base, h: Hypothesis) -> float:
    """Return the moment in s at which a slip `h` of a mount would explain most, if it began then.

    It is looked for everywhere, and about the loudest moment: one that hardly turns the sensor is seen by the peak
    alone, which is as short as it is.
    """

    def at(moments: Array) -> Hypothesis:
        return replace(h, effect=h.effect.at_moments(moments))

    before = at(BEFORE)
    prior = np.concatenate([np.full(p.width, p.std) for p in before.effect.parameters])
    still = slopes(base, before)
    after = After.of(base, still)
    times = [rows.time for rows in base.fit.rows if rows.name in still]
    begin, end = min(float(t[0]) for t in times), max(float(t[-1]) for t in times)

    def best(moments: Array) -> tuple[float, float]:
        lanes = int(np.ceil(CLEAR * SLIP / (moments[1] - moments[0]))) if len(moments) > 1 else 1
        promised = np.zeros(len(moments))
        for lane in range(min(lanes, len(moments))):
            some = moments[lane::lanes]
            promised[lane::lanes] = after.promises(some + SLIP, prior, slopes(base, at(some)), SLIP)
        return float(promised.max()), float(moments[np.argmax(promised)])

    def closer(moments: Array, apart: Sequence[float]) -> tuple[float, float]:
        for wide, close in pairwise(apart):
            middle = best(moments)[1]
            reach = wide if wide > APART[1] else AROUND * wide
            moments = np.arange(middle - reach, middle + reach + close / 2, close)
        return best(moments)

    apart = APART if end - begin < COARSE * APART[0] else ((end - begin) / COARSE, *APART)
    everywhere = np.arange(begin + APART[0], end - APART[0] / 2, apart[0])
    peak = loudest_moment([r for r in base.fit.measured if r.name in still])
    about: Array = peak + AT_PEAK * np.arange(-PEAKS, PEAKS + 1, dtype=float)
    return max(closer(everywhere, apart), closer(about, (AT_PEAK, AT_PEAK / 2)))[1]


def loudest_moment(rows: Sequence[Rows]) -> float:
    """Return when the stretch as long as a slip begins that a fit explains least."""
    time = np.concatenate([r.time for r in rows])
    power = np.concatenate([np.sum(r.whitened**2, axis=1) for r in rows])
    edges = np.arange(time.min(), time.max() + SLIP, SLIP / PARTS)
    steps = np.convolve(np.histogram(time, edges, weights=power)[0], np.ones(PARTS), "valid")
    return float(edges[np.argmax(steps)])


def slopes(base: Base, h: Hypothesis) -> dict[str, Array]:
    """Return what the parameters of an effect of the mount do to its IMU's whitened readings, (n, m, k) by group."""
    fit = base.fit
    model = fit.model.with_effects((*fit.model.hypotheses, h))
    shared, only = Parameters({h.key(p.name): p.width for p in h.effect.parameters}), Tracks(model.tracks.knots, {})
    with derivatives_by(shared.widths):
        rows = list(model.measured(started(model, fit.state), {h.at}))
    return {r.name: linearise(replace(r, std=base.std_of(r.name, r.std)), only, shared).border for r in rows}


__all__ = ["slip", "slopes"]
