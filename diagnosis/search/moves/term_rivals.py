"""Names that may only stand in for something without one: which are held against terms, against which, how strictly."""

from collections.abc import Sequence

import numpy as np

from imubench.diagnosis.config.shared import EVIDENCE
from imubench.diagnosis.config.verdict import FINDINGS
from imubench.diagnosis.discrepancy.basis_functions import drifts
from imubench.diagnosis.discrepancy.term_scores import FittedTerm, Guess
from imubench.diagnosis.discrepancy.terms import LATE, SERIES, Term
from imubench.diagnosis.problem.batch_model import inside
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.problem.motion_prior import states_inside

NEARLY = 0.25  # of what a filter is worth: a series worth no more than that more must gain more on left-out data
CLOSE = 0.01  # of what a name explains: an unfitted promise says no less (what it goes with, 10 ms late, is nearly it)
WANDERS = 0.2  # of what a spline explains that only wanders: a slow curve may explain so much less


def groups(hypotheses: Sequence[Hypothesis]) -> list[tuple[Hypothesis, ...]]:
    """Return what a term may displace: splines without a law, filters, effects of one triple alone, and all of it.

    Laws of friction are displaced together: each alone is worth little beside another. So are a filter and what it left
    to a delay and a scale at its IMU: hysteresis does some of all three. Last come all names of a fit: a dead zone
    was a filter at the other IMU, a scale and play, none of which could be spared.
    """
    plain = [h for h in hypotheses if not h.effect.states]
    free = [h for h in hypotheses if h.effect.free or (h.effect.states and h.effect.filters)]
    triples: dict[tuple[str, str], list[Hypothesis]] = {}
    for h in plain:
        triples.setdefault((h.at, acts_on(h)), []).append(h)
    rubbing = tuple(h for h in plain if h.effect.friction)
    lone = [h for h in plain if h not in rubbing]
    beside = [
        (f, *(h for h in plain if h.at == f.at and h.effect.name in f.effect.leaves_to))
        for f in free
        if f.effect.lawful
    ]
    several = [g for g in (*beside, *(tuple(some) for some in triples.values())) if len(g) > 1]
    out = [*((h,) for h in (*free, *lone)), *([rubbing] if rubbing else []), *several]
    return out if len(hypotheses) < 2 or any(len(g) == len(hypotheses) for g in out) else [*out, tuple(hypotheses)]


def acts_on(h: Hypothesis) -> str:
    """Return what effects at one place share that a term may stand for: a triple, the pose of a mount; else its name.

    A line is no curve that a term holds, on whatever triple it is.
    """
    if h.effect.misplaces or h.effect.onset:
        return "pose"
    return h.effect.name if h.effect.tone else h.effect.channel or h.effect.name


def margins(lost: float, slow: bool, free: bool, strained: bool, names: int = 1) -> tuple[float, float]:
    """Return the nat that a term must promise in the place of what names are worth, and by how many it may fall short.

    It may fall short once it is fitted: a curve of time in the place of what only wanders, names without a law or that
    break it, and several names of which one does more than one alone. A curve that promises less by twice as much is
    fitted all the same, because a promise is one linear step.
    """
    if slow:
        return (1 - 2 * WANDERS) * lost, WANDERS * lost
    if free or strained:
        least = EVIDENCE.clear_nat if free else (CLOSE if names == 1 else FINDINGS.much) * lost
        return (1 - FINDINGS.much) * lost, least
    return (1 + CLOSE) * lost, 0.0


def takes_place(
    found: FittedTerm, more: float, lost: float, names: Sequence[Hypothesis], free: bool, strained: bool
) -> bool:
    """Return whether a term that explains so much more than names of `lost` nat takes their place.

    A tie is enough where that has no law, or breaks its own. What could be its like must explain a tenth more: not a
    line's curve, whose bend is all its own, nor beside a filter what does not go with what the sensor read.
    """
    series = found.term.goes_with in SERIES
    if free or (strained and not series):
        return True
    filtered = names[0].effect.filters and together(names)
    unlike = found.term.drift or (filtered and not series)
    return more > max(EVIDENCE.clear_nat, 0.0 if unlike else FINDINGS.much * lost / found.louder)


def nearly_a_filter(found: FittedTerm, more: float, lost: float, names: Sequence[Hypothesis]) -> bool:
    """Return whether a term is a series that explains little more than a filter alone, of `lost` nat, in its place."""
    return len(names) == 1 and a_filter_is(found, names[0]) and more < NEARLY * lost


def together(names: Sequence[Hypothesis]) -> bool:
    """Return whether some names are at one place."""
    return len({h.at for h in names}) == 1


def is_a_drift(gone: Sequence[Hypothesis]) -> bool:
    """Return whether what may be displaced is one drift."""
    return len(gone) == 1 and gone[0].effect.time_power == 1


def a_filter_is(found: FittedTerm, h: Hypothesis) -> bool:
    """Return whether a term is what a filter does anyway."""
    return h.effect.filters and found.term.goes_with in SERIES


def comes_late(term: Term, h: Hypothesis) -> bool:
    """Return whether a term is what the axes of a misalignment read a little later."""
    return h.effect.crosses_axes and term.goes_with.endswith(LATE) and term.at == h.at


def seen_at(h: Hypothesis) -> str:
    """Return where a term that stands for an effect would be: at its IMU, or in the torque of a swing."""
    return h.at if h.effect.place == "imu" else "joint"


def wanders(guesses: Sequence[Guess], gone: Sequence[Hypothesis], lost: float) -> bool:
    """Return whether a curve of time explains as much, were the noise white, as an offset or a drift of `lost` nat.

    Noise as coloured as it may be forbids to believe the curve; it does not make the straight line sure.
    """
    if len(gone) > 1 or gone[0].effect.time_power is None:
        return False
    (at, part) = (gone[0].at, gone[0].effect.channel)
    return any(
        g.term.timed and g.term.drift and (g.term.at, g.term.part) == (at, part) and g.white > lost for g in guesses
    )


def only_wanders(fit: Fit, h: Hypothesis) -> bool:
    """Return whether what a joint does of its own is slow: play goes to and fro with the motion, a pivot with a hand.

    A mount that creeps is a slow turn. Where a slip is in the fit it has taken a step from the turn, or given it one. A
    pivot that is pushed one way for seconds would be metres off; an accelerometer's bias may wander so.
    """
    if not h.effect.slow_share:
        return False
    turned = np.concatenate([*states_inside(fit.model, fit.state, h).values()], axis=1)
    time = inside(fit.model)
    slips = [fit.state.values[o.key(o.effect.onset)] for o in fit.model.hypotheses if o.effect.onset]
    slow = np.column_stack([drifts(time), *(time > t for t in slips)])
    off = turned - turned[:1]
    left = off - slow @ np.linalg.lstsq(slow, off, rcond=None)[0]
    return float(np.sum(left**2)) < h.effect.slow_share * float(np.sum((turned - turned.mean(axis=0)) ** 2))


__all__ = [
    "NEARLY",
    "a_filter_is",
    "comes_late",
    "groups",
    "is_a_drift",
    "margins",
    "nearly_a_filter",
    "only_wanders",
    "takes_place",
    "together",
    "wanders",
]
