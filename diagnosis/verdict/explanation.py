"""What explains a recording: effects with a name, what has none, and the fits that say so."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

from imubench.diagnosis.budget import Budget
from imubench.diagnosis.candidates.begin import Beginning
from imubench.diagnosis.config.shared import CONFIDENCE
from imubench.diagnosis.config.verdict import BUDGET
from imubench.diagnosis.evidence import Trace
from imubench.diagnosis.noise.declared_noise import declared, declared_by
from imubench.diagnosis.noise.nominal import certain_effects
from imubench.diagnosis.problem.averaging import Averaging
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.residual_checks.fit_summary import Weighed, traces, weighed
from imubench.diagnosis.residual_checks.localize import locate
from imubench.diagnosis.residual_checks.regressors import regressors
from imubench.diagnosis.result import UNKNOWN, Finding, Pair, Rejected, Where
from imubench.diagnosis.rules import RuleUse
from imubench.diagnosis.samples.screening import SampleChecks
from imubench.diagnosis.search.rounding import beside_rounding
from imubench.diagnosis.search.selected import Selection
from imubench.diagnosis.search.unknown import unknowns
from imubench.diagnosis.search.unknown_against_laws import laws_for_series
from imubench.diagnosis.search.unknown_against_small import effects_for_terms, with_equals
from imubench.diagnosis.search.unnamed import Unknowns
from imubench.diagnosis.sensor_errors.baseline import Learned
from imubench.diagnosis.verdict.findings import findings, rejected
from imubench.diagnosis.verdict.impacts import unseen_knocks
from imubench.diagnosis.verdict.nameless_equivalents import with_equivalents, with_refused_equivalents
from imubench.diagnosis.verdict.play_impacts import impacts_of_play
from imubench.diagnosis.verdict.posterior import (
    doubted_beside_unknown,
    ranked_by_confidence,
    with_samples,
)
from imubench.diagnosis.verdict.timed_out import NAMELESS_TERMS, doubted_as_stopped, with_rest
from imubench.diagnosis.verdict.trust import allowed
from imubench.effects import traits_of
from imubench.effects.traits import Fault
from imubench.progress import Step
from imubench.recording import Recording

Findings = tuple[Finding, ...]


@dataclass(frozen=True)
class Work:
    """What a diagnosis is of, and within which bounds."""

    recording: Recording
    step: Step
    budget: Budget
    tolerance: Pair  # deg and mm that are material
    learned: Learned | None  # of the sensors, by a baseline
    use: RuleUse


@dataclass(frozen=True)
class Explanation:
    """What was found, and the fits that say so."""

    named: Findings
    rest: Findings  # what has no name
    refused: tuple[Rejected, ...]
    fit: Fit  # with everything that was found, terms for what has no name too
    numbers: Fit  # that the findings' numbers are of
    before: Weighed  # without any effect
    after: Weighed  # with everything
    where: tuple[Where, ...]  # the residuals of the fit without any effect are
    traces: tuple[Trace, ...]
    samples: SampleChecks  # what the raw samples show
    partly: bool  # whether the time limit kept something from being tried


def explained(work: Work, start: Beginning, chosen: Selection | None) -> Explanation:
    """Return what explains a recording.

    Args:
        work: what it is asked of.
        start: the fit without any effect.
        chosen: the effects that the search has found; None where it was not begun.
    """
    budget, use = work.budget, work.use
    averaging = start.first.model.averaging
    known = averaging.in_fit(declared_by(work.recording))
    before = weighed(start.first, known, averaging.in_fit(start.samples.white))
    where = tuple(locate(traces(before), regressors(start.first)))
    strange = Unknowns((), start.fit, ())
    if chosen:
        chosen, strange = with_unknowns(chosen, where, budget, use)
    fit, samples = strange.fit, start.samples
    rest = use.changed("told-by-samples", strange.findings, lambda r: not_told(r, samples.findings))
    noises, rest = noises_of(rest), tuple(f for f in rest if f.effect == UNKNOWN)
    louder = {f"{f.at}.{traits_of(f.effect).channel}": float(f.parameters["std"].value) for f in noises}
    after = weighed(fit, declared(start.fit.model) | louder)
    noises = tuple(of_recording(f, averaging) for f in noises)
    partly = bool(budget.not_tried) and chosen is not None
    rest = with_rest(rest, after) if partly else rest
    kept = {(h.effect.name, h.at) for h in fit.model.hypotheses}
    told, numbers = in_numbers(chosen, kept, fit, work.recording, budget) if chosen else ((), fit)
    fitted = tuple(f for f in (doubted_as_stopped(told) if partly else told) if (f.effect, f.at) in kept)
    refused = rejected(chosen) if chosen else ()
    rest = use.changed("like-unknown", rest, lambda r: with_equivalents(r, fitted))
    rest = use.changed("refused-as-equal", rest, lambda r: with_refused_equivalents(r, fitted, refused))
    sure = certain_effects(start.fit.model)
    fitted = use.changed(
        "doubt-beside-unknown", fitted, lambda f: doubted_beside_unknown(f, rest, strange.doubted, sure)
    )
    named = with_samples((*fitted, *noises), samples, rest)
    named = all_told(work, named, fit, samples, chosen)
    if chosen and not partly and any(f.confidence >= CONFIDENCE.counts for f in named):
        rest = use.changed(
            "left-beside-sure", rest, lambda r: not_told(with_rest(r, after, allowed(after)), samples.findings)
        )
    shown = traces(before, after if named or rest else None)
    return Explanation(named, rest, refused, fit, numbers, before, after, where, shown, samples, partly)


def all_told(work: Work, named: Findings, fit: Fit, samples: SampleChecks, chosen: Selection | None) -> Findings:
    """Return findings with knocks among them, what rounding may be doubted, the surest first; only what is new."""
    use, recording = work.use, work.recording
    with work.budget.rest("knocks that the raw samples doubt"):
        if chosen:
            springs = chosen.springs_refused
            named = use.changed(
                "knocks-that-samples-doubt", named, lambda n: (*n, *unseen_knocks(fit, samples.struck, n, springs))
            )
    named = use.changed("doubt-beside-rounding", named, lambda n: beside_rounding(n, recording, samples.humming))
    named = ranked_by_confidence(use.changed("knocks-of-play", named, lambda n: impacts_of_play(n, recording)))
    return named if work.learned is None else work.learned.new(named)


def with_unknowns(
    chosen: Selection, where: Sequence[Where], budget: Budget, use: RuleUse
) -> tuple[Selection, Unknowns]:
    """Return a selection with what it leaves unexplained, and with the effects that are names for that."""
    strange = Unknowns((), chosen.fit, ())
    with budget.part(BUDGET.terms, NAMELESS_TERMS):
        strange = unknowns(chosen.fit, where, use=use)
        for rules in (laws_for_series, effects_for_terms):
            if (told := chosen.on_with(rules(chosen, strange), use)) is not chosen:
                chosen, strange = told, unknowns(told.fit, where, use=use)
        equal = use.changed("equal-to-term", strange.findings, lambda _: with_equals(strange).findings)
        strange = replace(strange, findings=equal)
    return chosen, strange


def in_numbers(
    chosen: Selection, kept: Collection[tuple[str, str]], best: Fit, recording: Recording, budget: Budget
) -> tuple[Findings, Fit]:
    """Return the findings, and the fit that their numbers are of; both as the search left them where time is short."""
    with budget.rest("intervals, equivalents and what would tell these apart"):
        return findings(chosen, recording), numbered(chosen, kept) or best
    return findings(chosen, recording, briefly=True), best


def noises_of(rest: Sequence[Finding]) -> Findings:
    """Return the findings that are noise louder than declared."""
    return tuple(f for f in rest if f.effect != UNKNOWN)


def of_recording(noise: Finding, averaging: Averaging) -> Finding:
    """Return a noise that the fit leaves as the recording's samples have it."""
    share = averaging.share(f"{noise.at}.{traits_of(noise.effect).channel}")
    numbers = {name: replace(p, value=p.value / share, std=p.std / share) for name, p in noise.parameters.items()}
    return replace(noise, parameters=numbers)


def not_told(rest: Sequence[Finding], told: Sequence[Finding]) -> Findings:
    """Return what is no part of what the samples told already: rounding, or what knocks leave that were not left out.

    Rounding goes with the signal. A knock that stays in the fit is loud, and no term has it: it gains nothing there.
    """
    rounded, struck = (
        {f.at for f in told if traits_of(f.effect).fault is fault} for fault in (Fault.ROUNDED, Fault.STRUCK)
    )
    loud = [f for f in rest if f.effect == UNKNOWN and not f.heldout_gain.value]
    return tuple(f for f in rest if f.at not in rounded and not (f in loud and f.at in struck))


def numbered(chosen: Selection, kept: Collection[tuple[str, str]]) -> Fit | None:
    """Return the fit that the findings' numbers are of, in which no term without a name holds a share of a mount's.

    None where a name that moves a sensor or a joint is not `kept`: then the terms say where these are.
    """
    gone = [k.hypothesis.effect for k in chosen.kept if (k.hypothesis.effect.name, k.hypothesis.at) not in kept]
    return chosen.numbers if all(effect.acts("error") for effect in gone) else None


__all__ = ["Explanation", "Work", "explained", "not_told"]
