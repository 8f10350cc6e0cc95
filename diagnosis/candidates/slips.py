"""When a mount slipped: what a slip at each of many moments would explain, motion and geometry free to follow."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.candidates import SLIP_SCAN
from imubench.diagnosis.criteria.onset_scan import After
from imubench.diagnosis.problem.batch_model import started
from imubench.diagnosis.problem.bspline import Tracks
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.problem.residuals import Parameters, Rows
from imubench.diagnosis.solve.linearize import linearise
from imubench.diagnosis.solve.schur import Base
from imubench.effects.mounts import SLIP
from imubench.jets import derivatives_by

BEFORE_THE_RECORDING = np.array([-1e9])  # s: it has slipped long since


def slip(base: Base, h: Hypothesis) -> float:
    """Return the moment in s at which a slip `h` of a mount would explain most, if it began then.

    It is looked for everywhere, and about the loudest moment: one that hardly turns the sensor is seen by the peak
    alone, which is as short as it is.
    """

    def at(moments: Array) -> Hypothesis:
        return replace(h, effect=h.effect.at_moments(moments))

    before = at(BEFORE_THE_RECORDING)
    prior = np.concatenate([np.full(p.width, p.std) for p in before.effect.parameters])
    still = slopes(base, before)
    after = After.of(base, still)
    times = [rows.time for rows in base.fit.rows if rows.name in still]
    begin, end = min(float(t[0]) for t in times), max(float(t[-1]) for t in times)

    def best(moments: Array) -> tuple[float, float]:
        lanes = int(np.ceil(SLIP_SCAN.clear * SLIP / (moments[1] - moments[0]))) if len(moments) > 1 else 1
        promised = np.zeros(len(moments))
        for lane in range(min(lanes, len(moments))):
            some = moments[lane::lanes]
            promised[lane::lanes] = after.promises(some + SLIP, prior, slopes(base, at(some)), SLIP)
        return float(promised.max()), float(moments[np.argmax(promised)])

    def closer(moments: Array, apart: Sequence[float]) -> tuple[float, float]:
        for wide, close in pairwise(apart):
            middle = best(moments)[1]
            reach = wide if wide > SLIP_SCAN.apart_s[1] else SLIP_SCAN.around * wide
            moments = np.arange(middle - reach, middle + reach + close / 2, close)
        return best(moments)

    apart = (
        SLIP_SCAN.apart_s
        if end - begin < SLIP_SCAN.coarse_moments * SLIP_SCAN.apart_s[0]
        else ((end - begin) / SLIP_SCAN.coarse_moments, *SLIP_SCAN.apart_s)
    )
    everywhere = np.arange(begin + SLIP_SCAN.apart_s[0], end - SLIP_SCAN.apart_s[0] / 2, apart[0])
    peak = loudest_moment([r for r in base.fit.measured if r.name in still])
    about: Array = peak + SLIP_SCAN.peak_s * np.arange(-SLIP_SCAN.peak_moments, SLIP_SCAN.peak_moments + 1, dtype=float)
    return max(closer(everywhere, apart), closer(about, (SLIP_SCAN.peak_s, SLIP_SCAN.peak_s / 2)))[1]


def loudest_moment(rows: Sequence[Rows]) -> float:
    """Return when the stretch as long as a slip begins that a fit explains least."""
    time = np.concatenate([r.time for r in rows])
    power = np.concatenate([np.sum(r.whitened**2, axis=1) for r in rows])
    edges = np.arange(time.min(), time.max() + SLIP, SLIP / SLIP_SCAN.parts)
    steps = np.convolve(np.histogram(time, edges, weights=power)[0], np.ones(SLIP_SCAN.parts), "valid")
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
