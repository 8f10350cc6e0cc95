"""From a recording to a diagnosis: fit the motion, weigh what is left, locate it, say what it is."""

from collections.abc import Collection, Sequence
from dataclasses import replace
from time import perf_counter

from imubench.diagnosis.budget import Budget
from imubench.diagnosis.candidates.begin import begin
from imubench.diagnosis.config.shared import CONFIDENCE
from imubench.diagnosis.config.verdict import BUDGET
from imubench.diagnosis.evidence import Evidence
from imubench.diagnosis.noise.nominal import certain_effects
from imubench.diagnosis.noise.reml import declared, declared_by
from imubench.diagnosis.nonsense import nonsense
from imubench.diagnosis.nonsense.diagnosed_without_fit import diagnosed_without_fit
from imubench.diagnosis.nonsense.permuted import permuted
from imubench.diagnosis.residual_checks import fit_summary
from imubench.diagnosis.residual_checks.excess_noise import refuted
from imubench.diagnosis.residual_checks.localize import acting_in, locate
from imubench.diagnosis.residual_checks.regressors import regressors
from imubench.diagnosis.result import (
    NOT_KNOWN,
    TOLERANCE,
    UNKNOWN,
    Diagnosis,
    Doubt,
    Finding,
    FitQuality,
    Move,
    Moves,
    Pair,
    SensorErrors,
    Verdict,
    Where,
)
from imubench.diagnosis.samples.screening import SampleChecks
from imubench.diagnosis.search.rounding import beside_rounding, sharp
from imubench.diagnosis.search.selection import FURTHER, Selection, select
from imubench.diagnosis.search.unknown import Unknowns, unknowns
from imubench.diagnosis.search.unknown_against_laws import named_by_law
from imubench.diagnosis.search.unknown_against_small import named_by_size, with_equals
from imubench.diagnosis.sensor_errors.baseline import Learned, check_same_sensors
from imubench.diagnosis.sensor_errors.own_errors import own_errors
from imubench.diagnosis.simulation.step import judged_by_simulation
from imubench.diagnosis.solve.levenberg_marquardt import Fit
from imubench.diagnosis.verdict.findings import findings, rejected
from imubench.diagnosis.verdict.impacts import unseen_knocks
from imubench.diagnosis.verdict.left_out_sensor import left_out_change
from imubench.diagnosis.verdict.nameless_equivalents import with_equivalents, with_refused_equivalents
from imubench.diagnosis.verdict.play_impacts import impacts_of_play
from imubench.diagnosis.verdict.posterior import (
    doubted_beside_hum,
    doubted_beside_unknown,
    noise_not_shown,
    not_observable,
    ranked_by_confidence,
    verdict_of,
    with_samples,
)
from imubench.diagnosis.verdict.timed_out import NAMELESS_TERMS as UNNAMED
from imubench.diagnosis.verdict.timed_out import doubted_as_stopped, not_fitted, verdict_when_stopped, with_rest
from imubench.diagnosis.verdict.trust import allowed, doubts
from imubench.diagnosis.verdict.without_finding import moves_of, moves_of_all, with_moves
from imubench.effects.effect import Effect
from imubench.progress import Step, silent
from imubench.recording import Recording, require_known_rig


def diagnose(
    recording: Recording,
    step: Step = silent,
    budget: Budget | None = None,
    tolerance: Pair = TOLERANCE,
    baseline: Diagnosis | None = None,
) -> tuple[Diagnosis, Evidence]:
    """Return what a recording says about the model it was declared with, and what shows it.

    Args:
        recording: of a rig of the project; see `require_known_rig`.
        step: told what is being done.
        budget: the processor time that it may take; None: as much as it takes. Where that is spent, what is known by
            then is returned, with what was not tried.
        tolerance: deg and mm; a finding that moves less of all that a user asks for is not material.
        baseline: of an undisturbed recording of the same sensors; what that says of the sensors themselves is known,
            and only what is new is found. See `baseline`.

    Raises:
        InputError: for a rig of one's own, or a baseline of other sensors.
    """
    clock = perf_counter()
    require_known_rig(recording, "a diagnosis")
    budget = budget or Budget()
    if baseline is not None:
        check_same_sensors(baseline, recording)
    learned = None if baseline is None else Learned.of(baseline)
    with step("hold the sensors against each other"):
        wrong = nonsense(recording)
    if wrong:
        said, shown = diagnosed_without_fit(recording, wrong, clock)
        return replace(said, tolerance=tolerance), shown
    start = begin(recording, step, budget, learned)
    samples, first, fit = start.samples, start.first, start.fit
    unseen = not_observable(recording) if start.finished else not_fitted(budget)
    chosen = None
    with step("find what was left out"), budget.part(BUDGET.search, FURTHER):
        chosen = select(fit, rounding=sharp(samples.findings, recording)) if not unseen else None
    budget.missed(*(chosen.not_tried if chosen else ()))
    stated, now = declared_by(recording), declared(fit.model)
    with step("weigh and locate what is left"):
        before = fit_summary.weighed(first, stated, samples.white)
        where = locate(fit_summary.traces(before), regressors(first))
        strange = Unknowns((), fit, ())
        if chosen:
            chosen, strange = with_unknowns(chosen, where, budget)
        rest, best = strange.findings, strange.fit
        samples = samples.without(refuted(samples.findings, best, {f.at for f in rest}))
        rest = not_told(rest, samples.findings)
        noises = tuple(f for f in rest if f.effect != UNKNOWN)
        rest = tuple(f for f in rest if f.effect == UNKNOWN)
        now |= {f"{f.at}.{f.effect.removesuffix('_noise')}": float(f.parameters["std"].value) for f in noises}
        after = fit_summary.weighed(best, now)
        partly = bool(budget.not_tried) and chosen is not None
        rest = with_rest(rest, after) if partly else rest
        kept = {(h.effect.name, h.at) for h in best.model.hypotheses}
        told, plain = in_numbers(chosen, kept, best, recording, budget) if chosen else ((), best)
        fitted = tuple(f for f in (doubted_as_stopped(told) if partly else told) if (f.effect, f.at) in kept)
        refused = rejected(chosen) if chosen else ()
        rest = with_refused_equivalents(with_equivalents(rest, fitted), fitted, refused)
        noises = doubted_beside_hum(noises, (*fitted, *samples.findings))
        named = with_samples(
            (*doubted_beside_unknown(fitted, rest, strange.doubted, certain_effects(fit.model)), *noises), samples, rest
        )
        with budget.part(BUDGET.numbers, "knocks that the raw samples doubt"):
            named += unseen_knocks(best, samples.struck, named, chosen.springs_refused) if chosen else ()
        named = ranked_by_confidence(impacts_of_play(beside_rounding(named, recording, samples.humming), recording))
        named = named if learned is None else learned.new(named)
        if chosen and not partly and any(f.confidence >= CONFIDENCE.counts for f in named):
            rest = not_told(with_rest(rest, after, allowed(after)), samples.findings)
        traces = fit_summary.traces(before, after if named or rest else None)
    without: dict[tuple[str, str], Fit] = {}
    with step("see what each finding moves"):
        named, rest = material(named, rest, best, samples, recording, budget, tolerance, without)
    all_moves: Moves = {}
    with budget.part(BUDGET.numbers, "what all findings move together"):
        all_moves = moves_of_all(best, recording, tolerance)
    with step("ask whether the halves agree"):
        doubted_by = speaking_against(plain, before, after, named, budget)
    noise = fit_summary.noise_of(before.levels, recording, samples.rest)
    noise = noise if learned is None else learned.known(noise)
    sensors: tuple[SensorErrors, ...] = ()
    if chosen:  # one step of the solver: owed whatever the time, for what takes it over
        with step("say what the sensors' own errors are"):
            sensors = own_errors(best)
    nobody = [name for name, level in noise.items() if level.source == NOT_KNOWN]
    again = fit_summary.replayed(plain, best)
    evidence = Evidence(
        recording,
        traces,
        fit_summary.played(again),
        fit_summary.mounts(again),
        before.levels,
        motion_before=fit_summary.played(first) if named else None,
        notes=(
            f"A spline motion with {fit.model.tracks.knots.count} knots and the mounts were fitted to every sample.",
            "Every effect was scored; the best were fitted exactly and judged on blocks of 5 s that they had not seen.",
            *samples.notes,
        ),
    )
    with step("play the simulations beside the recording"):
        simulation, evidence, acting = judged_by_simulation(evidence, first, plain, (*named, *rest), without, budget)
    verdict: Verdict = "unobservable" if unseen else verdict_of(named, rest, nobody, bool(doubted_by))
    if partly:
        verdict, unseen = verdict_when_stopped(named, rest, after, nobody, bool(doubted_by))
    if nobody and verdict == "partly explained":
        unseen = (*unseen, noise_not_shown(nobody))
    quality = FitQuality((before.left_out, after.left_out))
    if named or rest:
        with budget.part(BUDGET.numbers, "channels left out"):
            quality = FitQuality(quality.heldout, left_out_change(before, after))
    if acting:  # the residuals of a motion that is free to push a swing's friction anywhere say nothing of that
        prescribed = simulation is not None and simulation.how == "prescribed"
        where = acting_in(acting, where if prescribed else ())
    diagnosis = Diagnosis(
        recording.name,
        recording.rig,
        verdict,
        (before.misfit, after.misfit),
        where,
        (*named, *rest),
        refused,
        quality,
        "",
        perf_counter() - clock,
        unseen,
        permuted((*named, *rest), recording),
        budget.stopped,
        tuple(budget.not_tried),
        noise,
        tolerance,
        sensors,
        None if learned is None else learned.record,
        doubts=doubted_by if verdict == "partly explained" else (),
        simulation=simulation,
        moves=all_moves,
    )
    return diagnosis, evidence


def speaking_against(
    fit: Fit, before: fit_summary.Weighed, after: fit_summary.Weighed, named: Sequence[Finding], budget: Budget
) -> tuple[Doubt, ...]:
    """Return what speaks against the model with the findings in it; nothing where there is none."""
    found: tuple[Doubt, ...] = ()
    if any(f.confidence >= CONFIDENCE.counts for f in named) and fit.model.hypotheses:
        with budget.part(BUDGET.numbers, "whether the halves of the recording agree"):
            found = doubts(fit, before, after)
    return found


def material(
    named: tuple[Finding, ...],
    rest: tuple[Finding, ...],
    fit: Fit,
    samples: SampleChecks,
    recording: Recording,
    budget: Budget,
    tolerance: Pair,
    without: dict[tuple[str, str], Fit],
) -> tuple[tuple[Finding, ...], tuple[Finding, ...]]:
    """Return findings with and without a name, with what each moves and whether that is material.

    Fits without one of them are put into `without`, by effect and place.
    """
    moves: dict[int, dict[str, Move]] = {}
    with budget.part(BUDGET.numbers, "what each finding moves"):
        for finding, known in moves_of((*named, *rest), fit, samples, recording, without):
            moves[id(finding)] = known
    return with_moves(named, moves, tolerance), with_moves(rest, moves, tolerance)


def with_unknowns(chosen: Selection, where: Sequence[Where], budget: Budget) -> tuple[Selection, Unknowns]:
    """Return a selection with what it leaves unexplained, and with the effects that are names for that."""
    strange = Unknowns((), chosen.fit, ())
    with budget.part(BUDGET.terms, UNNAMED):
        strange = unknowns(chosen.fit, where)
        for naming in (named_by_law, named_by_size):
            if (told := naming(chosen, strange)) is not chosen:
                chosen, strange = told, unknowns(told.fit, where)
        strange = with_equals(strange)
    return chosen, strange


def in_numbers(
    chosen: Selection, kept: Collection[tuple[str, str]], best: Fit, recording: Recording, budget: Budget
) -> tuple[tuple[Finding, ...], Fit]:
    """Return the findings, and the fit that their numbers are of; both as the search left them where time is short."""
    with budget.part(BUDGET.numbers, "intervals, equivalents and what would tell these apart"):
        return findings(chosen, recording), numbered(chosen, kept) or best
    return findings(chosen, recording, briefly=True), best


def not_told(rest: Sequence[Finding], told: Sequence[Finding]) -> tuple[Finding, ...]:
    """Return what is no part of what the samples told already: rounding, or what knocks leave that were not left out.

    Rounding goes with the signal. A knock that stays in the fit is loud, and no term has it: it gains nothing there.
    """
    rounded, struck = ({f.at for f in told if f.effect == effect} for effect in ("quantisation", "impacts"))
    loud = [f for f in rest if f.effect == UNKNOWN and not f.heldout_gain.value]
    return tuple(f for f in rest if f.at not in rounded and not (f in loud and f.at in struck))


def numbered(chosen: Selection | None, kept: Collection[tuple[str, str]]) -> Fit | None:
    """Return the fit that the findings' numbers are of, in which no term without a name holds a share of a mount's.

    None where a name that moves a sensor or a joint is not `kept`: then the terms say where these are.
    """
    if chosen is None:
        return None
    gone = [k.hypothesis.effect for k in chosen.kept if (k.hypothesis.effect.name, k.hypothesis.at) not in kept]
    return chosen.numbers if all(type(effect).error is not Effect.error for effect in gone) else None


__all__ = ["diagnose", "not_told"]
