"""Effects that have a life of their own: screened by their laws, tried on a part, fitted to the whole."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace

import numpy as np

from imubench.diagnosis.config.criteria import ADMISSION
from imubench.diagnosis.config.noise import REML
from imubench.diagnosis.config.shared import EVIDENCE
from imubench.diagnosis.criteria.dynamic_aic import trial_beside
from imubench.diagnosis.criteria.dynamic_score import Screened, screen
from imubench.diagnosis.criteria.plausible_fit import holds_its_law
from imubench.diagnosis.criteria.trial import Trial
from imubench.diagnosis.noise.declared_noise import breaks_its_law, misfit
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.search.moves.dynamic_order import pairs, promising, softer
from imubench.diagnosis.search.moves.dynamic_refits import (
    on_whole_recording,
    refit_beside,
    refit_from_screening,
)
from imubench.diagnosis.search.moves.move import Promises
from imubench.diagnosis.solve.block_tridiagonal import NotPositiveDefiniteError
from imubench.diagnosis.solve.subset import excerpt, loudest
from imubench.diagnosis.solve.threads import side_by_side

FREE = 0.75  # of what a state without a law explains, that one with a law must
BROKEN_LAW_SHARE = 0.5  # of what a filter explains that breaks its law
MORE_OF_TWO = 0.1  # of what the best alone is worth, that two must be worth more, and `EVIDENCE.certain_nat`
SHORT = 0.5  # of what a screening promised: springs that are worth less are begun anew
HOPELESS = -150.0  # nat: from a refit worth less no softer start leads anywhere (of 14, one from -185 to -42)
MOST_IN_VAIN = 2  # refits without evidence, after which a lower promise is not refitted


def state_trials(
    fit: Fit,
    stateful: list[Hypothesis],
    say: Callable[[str], None],
    least: float = EVIDENCE.needed_nat,
    vain: Promises | None = None,
) -> list[Trial]:
    """Return refits with effects that have states, best evidence first; none where none is needed.

    They are screened. Those that promise more than `least` nat of a motion that follows their law (not of one that goes
    against it, as in a free body with nothing wrong) are tried on the seconds with the largest residuals. Only the best
    is fitted to the whole recording, and comes first. The gains of the others are scaled to the length of the whole.
    `vain` has what each promised when a refit was worth nothing, in this round or before. After `MOST_IN_VAIN` such
    refits an effect is not asked again, unless it promises more than it did then.
    """
    vain = {} if vain is None else vain
    if not stateful:
        return []
    window = loudest(fit, ADMISSION.screened_s)
    whole = window == fit.span
    short = fit if whole else excerpt(fit, *window)
    short = with_noise(short, 2)  # as what it is held against
    say("screening effects with states")
    lone = len(fit.model.recording.imus) == 1 and not fit.model.wander
    puzzling = misfit(short) > ADMISSION.unexplained_misfit and not fit.model.wander
    screened = [s for s in screen(short, stateful) if worth_asking(s, vain)]
    likely, tried = _one_by_one(short, promising(screened, least, lone, puzzling), say)
    for t, begun in (t for t in tried if t[0].evidence <= EVIDENCE.needed_nat):
        vain[t.hypothesis.name] = [*vain.get(t.hypothesis.name, []), begun[0].evidence]
    worth_it = {t.hypothesis.name for t, _ in tried if t.evidence > EVIDENCE.needed_nat}
    both = [p for p in pairs(likely) if worth_it & {s.hypothesis.name for s in p}]  # one alone is worth something too
    tried += _paired(short, tried, both, say)
    tried = sorted(
        (t for t in tried if t[0].evidence > EVIDENCE.needed_nat and holds_its_law(t[0])),
        key=lambda t: -explained(t[0]),
    )
    if not tried:
        return []
    (best, some), *others = tried
    if whole:
        return [trial_beside(fit, [best.hypothesis, *best.also], best.fit), *(t for t, _ in others)]
    say(f"refitting with {best.hypothesis.name} on the whole recording")
    on_all = _on_all(fit, best, some)
    if on_all is None:
        return []
    scale = on_all.evidence / best.evidence
    rest = [replace(t, evidence=t.evidence * scale) for t, _ in others if scale > 0]
    return [on_all, *rest]


def worth_asking(one: Screened, vain: Promises) -> bool:
    """Return whether a screened effect was not refitted for nothing often enough, or promises more than it did."""
    promised = vain.get(one.hypothesis.name, [])
    return len(promised) < MOST_IN_VAIN or one.evidence > max(promised)


def explained(trial: Trial) -> float:
    """Return what a trial is worth beside others, in nat.

    Less for states without a law, which do what a spring does and more; less also for a filter that breaks its law,
    because its readings have taken in what belongs to another effect.
    """
    h = trial.hypothesis
    broken = h.effect.filters and breaks_its_law(trial.fit, h)
    return trial.evidence * (FREE if not h.effect.lawful else BROKEN_LAW_SHARE if broken else 1.0)


def _one_by_one(
    short: Fit, promised: list[list[Screened]], say: Callable[[str], None]
) -> tuple[list[Screened], list[tuple[Trial, list[Screened]]]]:
    """Return the screenings that were refitted last, and all refits.

    The next are tried where none was any good, where the best has no law (it explains what any other would), and where
    the best leaves much: it may stand for a better one.
    """

    def refitted(one: Screened) -> tuple[Trial, list[Screened]] | None:
        say(f"refitting with {one.hypothesis.name}")
        ways = []
        for begin in filter(None, (one, softer(one))):
            with suppress(NotPositiveDefiniteError):
                ways.append((refit_from_screening(short, [begin]), [begin]))
            if ways and not HOPELESS < ways[-1][0].evidence < SHORT * one.evidence:
                break
        return max(ways, key=lambda way: way[0].evidence, default=None)

    likely: list[Screened] = []
    tried: list[tuple[Trial, list[Screened]]] = []
    for likely in promised:
        tried += [t for t in side_by_side(refitted, likely, short.model.tracks.knots.count) if t is not None]
        best = max((t for t, _ in tried if holds_its_law(t)), key=explained, default=None)
        good = best is not None and best.evidence > EVIDENCE.needed_nat and best.hypothesis.effect.lawful
        if best is not None and good and (short.model.wander or misfit(best.fit) < ADMISSION.unexplained_misfit):
            break  # a sensor beside errors that wander leaves more than its quiet moments say, whatever moves
    return likely, tried


def _on_all(fit: Fit, best: Trial, some: list[Screened]) -> Trial | None:
    """Return the best trial on the whole recording: grown from its part, or where that is worse begun anew."""
    ways: list[Trial] = []
    with suppress(NotPositiveDefiniteError):
        ways.append(on_whole_recording(fit, best))
    if not ways or ways[0].evidence < best.evidence:
        with suppress(NotPositiveDefiniteError):
            ways.append(refit_from_screening(fit, some, rounds=REML.last_rounds))
    found = max(ways, key=lambda t: t.evidence, default=None)
    return found if found is not None and holds_its_law(found) else None


def _paired(
    short: Fit, single: list[tuple[Trial, list[Screened]]], both: list[list[Screened]], say: Callable[[str], None]
) -> list[tuple[Trial, list[Screened]]]:
    """Return the best refit with two, begun where one of them alone had come to, or as both were screened.

    One way is enough where something else alone explains more than that. None is needed where the better one leaves
    nothing that the other would explain. Two that share what was left are worth several times one of them. One that is
    worth little beside another can be found in a later round, alone; what it takes from a law that holds only
    approximately is not accepted there.
    """
    out: list[tuple[Trial, list[Screened]]] = []
    for some in both:
        if not _left_for_two(single, some):
            continue
        say(f"refitting with {' and '.join(s.hypothesis.name for s in some)}")
        alone = {t.hypothesis.name: t for t, _ in single}
        names = {s.hypothesis.name for s in some}
        rival = max((t.evidence for name, t in alone.items() if name not in names), default=-np.inf)
        ways = [(alone[a.hypothesis.name], b) for a, b in (some, some[::-1]) if a.hypothesis.name in alone]
        for way in (*ways, None):
            with suppress(NotPositiveDefiniteError):
                out.append((refit_from_screening(short, some) if way is None else refit_beside(short, *way), some))
                if out[-1][0].evidence < rival:
                    break
    alone_best = max((t.evidence for t, _ in single), default=0.0)
    worth_it = [t for t in out if t[0].evidence > alone_best + max(EVIDENCE.certain_nat, MORE_OF_TWO * alone_best)]
    return [max(worth_it, key=lambda t: t[0].evidence)] if worth_it else []


def _left_for_two(single: list[tuple[Trial, list[Screened]]], some: list[Screened]) -> bool:
    """Return whether a screening beside the better one of two promises enough of the other."""
    names = [s.hypothesis for s in some]
    best = max((t for t, _ in single if t.hypothesis in names), key=lambda t: t.evidence)
    least = max(EVIDENCE.needed_nat, MORE_OF_TWO * best.evidence)
    return any(s.evidence > least for s in screen(best.fit, [h for h in names if h != best.hypothesis]))


__all__ = ["SHORT", "explained", "state_trials"]
