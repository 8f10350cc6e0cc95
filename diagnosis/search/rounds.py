"""One round of the search: what could come into the fit next, the best of it refitted exactly."""

from collections.abc import Callable, Collection
from dataclasses import replace

from imubench.diagnosis.config.shared import EVIDENCE
from imubench.diagnosis.criteria.followed_sensor import at_levels, nearer_to_declared, uncertain_levels
from imubench.diagnosis.criteria.trial import Trial
from imubench.diagnosis.discrepancy.input_nonlinearity import reads_by_own_law
from imubench.diagnosis.noise.declared_noise import misfit
from imubench.diagnosis.noise.masking import mask_beside, shows_in_its_moments, with_mask
from imubench.diagnosis.noise.reml import with_noise, with_settled_noise
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.rules import RuleUse
from imubench.diagnosis.search.dynamic_candidates import (
    CLEARLY,
    before_plain,
    promised_by_law,
    stateful,
    suspicious,
)
from imubench.diagnosis.search.moves.add import next_plain, plain_scores, plain_trials
from imubench.diagnosis.search.moves.add_dynamic import explained, state_trials
from imubench.diagnosis.search.moves.move import Promises, Round, SearchState

AHEAD = 3  # effects without states that are tried together before one with states is
LITTLE = 0.7  # of the excess misfit: an effect that leaves more has not explained it


def next_round(state: SearchState, say: Callable[[str], None]) -> Round:
    """Return what could come into the fit of a search next, of what its last round has left to ask."""
    rounds = state.rounds
    everything = list(state.everything if rounds.asked is None else rounds.asked)
    return try_round(state.fit, everything, say, rounds.vain, rounds.heard, state.use)


def try_round(
    fit: Fit,
    everything: list[Hypothesis],
    say: Callable[[str], None],
    vain: Promises | None = None,
    heard: Collection[str] = (),
    use: RuleUse | None = None,
) -> Round:
    """Return what could come into the fit next, of effects that are not in it.

    `vain` is that of `state_trials`, `heard` that of `stateful`, `use` the rules that may be applied; None: all.
    """
    use = use or RuleUse()
    say("scoring every effect")
    taken = {h.name for h in fit.model.hypotheses}
    left = [h for h in everything if h.name not in taken]
    plain, scores = plain_scores(fit, left)
    tried = [t for t in plain_trials(fit, scores, say) if t.evidence > EVIDENCE.needed_nat]
    if use.on("quiet-where-uncertain") and (told := uncertain_levels(fit)):
        quiet = at_levels(fit, told)
        quieter = plain_trials(quiet, plain_scores(quiet, left)[1], say)
        nearer = [t for t in quieter if t.evidence > EVIDENCE.needed_nat and nearer_to_declared(fit, t, told)]
        tried = nearer if use.holds("quiet-where-uncertain", lambda: bool(nearer)) else tried
    first = with_noise(tried[0].fit) if tried else fit
    brief = bool(tried) and use.holds("moment-tells", lambda: shows_in_its_moments(fit, first, tried[0].hypothesis))
    windows = mask_beside(first, tried[0].hypothesis) if tried and not brief else None
    if windows and use.holds("mask-beside-best", lambda: True):
        first, fit = with_noise(with_mask(first, windows)), with_mask(fit, windows)
        tried = [tried[0], *(replace(t, fit=with_mask(t.fit, windows)) for t in tried[1:])]  # all on the same samples
    chain = ahead(fit, first, plain, say) if tried and use.on("plain-ahead") else []
    use.holds("plain-ahead", lambda: bool(chain))
    further = chain[-1].fit if chain else first
    moving = suspicious(further)
    hinted = max([EVIDENCE.certain_nat, promised_by_law(further), *(t.evidence for t in tried)])
    least = EVIDENCE.needed_nat if moving else hinted
    ruled = moving and use.holds("own-law-of-reading", lambda: reads_by_own_law(further))
    alive = [] if ruled else stateful(fit, left, moving, least > EVIDENCE.certain_nat, heard)
    lively = [
        t for t in dynamic_trials(fit, left, alive, say, least, vain, use) if t.evidence > promised_by_law(further)
    ]
    if lively and before_plain(lively[0], fit, further):
        return Round(fit, lively + tried, with_settled_noise(lively[0].fit), [], True)
    return Round(fit, tried + lively, first, chain if moving else [], bool(alive), brief, plain)


def dynamic_trials(
    fit: Fit,
    left: list[Hypothesis],
    alive: list[Hypothesis],
    say: Callable[[str], None],
    least: float,
    vain: Promises | None,
    use: RuleUse | None = None,
) -> list[Trial]:
    """Return the refits with states; where springs alone were asked and explain much, beside what has no law.

    A pivot that shakes may leave a lone IMU little more than its noise, and springs then stand in for it.
    """
    tried = state_trials(fit, alive, say, least, vain)
    use = use or RuleUse()
    if not tried or tried[0].evidence < CLEARLY or any(h.effect.free for h in alive):
        return tried
    if not use.on("free-beside-springs"):
        return tried
    free = [h for h in stateful(fit, left, True, False) if h.effect.free]
    freely = state_trials(fit, free, say, least, vain)
    use.holds("free-beside-springs", lambda: bool(freely))
    return sorted([*freely[:1], *tried[:1]], key=lambda t: -explained(t)) + tried[1:]


def ahead(fit: Fit, better: Fit, plain: list[Hypothesis], say: Callable[[str], None]) -> list[Trial]:
    """Return more effects without states than the one in `better`, while each takes much of what is left before it.

    A free spline explains nearly anything, two scales of a sensor too: it is not asked while scales do. Where it is
    asked and explains less, all of these are taken: what only stood in for a spline is dropped once that is in.
    """
    out: list[Trial] = []
    for _ in range(AHEAD):
        if not suspicious(better) or misfit(better) - 1 > LITTLE * max(misfit(fit) - 1, 0.0):
            break
        say("looking whether more effects without states explain it")
        found = next_plain(better, plain, say)
        if found is None:
            break
        fit, better = better, found.fit
        out.append(found)
    return out


__all__ = ["next_round", "try_round"]
