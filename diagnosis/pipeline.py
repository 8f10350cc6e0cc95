"""From a recording to a diagnosis: fit the motion, weigh what is left, locate it, say what it is."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from time import perf_counter

from imubench.diagnosis.budget import Budget
from imubench.diagnosis.candidates.begin import Beginning, begin
from imubench.diagnosis.config.shared import CONFIDENCE, DECLARED_NOISE
from imubench.diagnosis.config.verdict import BUDGET
from imubench.diagnosis.evidence import Evidence
from imubench.diagnosis.noise.declared_noise import misfit
from imubench.diagnosis.nonsense import nonsense
from imubench.diagnosis.nonsense.diagnosed_without_fit import diagnosed_without_fit
from imubench.diagnosis.nonsense.permuted import permuted
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.remembered import remembering
from imubench.diagnosis.residual_checks import fit_summary
from imubench.diagnosis.residual_checks.localize import acting_in
from imubench.diagnosis.residual_checks.whole_motion import to_the_ends
from imubench.diagnosis.result import (
    NOT_KNOWN,
    TOLERANCE,
    Diagnosis,
    Doubt,
    FitQuality,
    Move,
    Moves,
    Noise,
    Pair,
    SensorErrors,
    Unseen,
    Verdict,
)
from imubench.diagnosis.rules import Rules, RuleUse, used
from imubench.diagnosis.search.rounding import sharp
from imubench.diagnosis.search.selected import Selection
from imubench.diagnosis.search.selection import FURTHER, select
from imubench.diagnosis.sensor_errors.baseline import Learned, check_same_sensors
from imubench.diagnosis.sensor_errors.own_errors import own_errors
from imubench.diagnosis.simulation.step import judged_by_simulation
from imubench.diagnosis.verdict.believed import believed
from imubench.diagnosis.verdict.explanation import Explanation, Work, explained
from imubench.diagnosis.verdict.left_out_sensor import left_out_change
from imubench.diagnosis.verdict.posterior import (
    noise_not_shown,
    not_observable,
    verdict_of,
)
from imubench.diagnosis.verdict.timed_out import HALVES_AGREE, not_asked, not_fitted, verdict_when_stopped
from imubench.diagnosis.verdict.trust import doubts
from imubench.diagnosis.verdict.without_finding import moves_of, moves_of_all, with_moves
from imubench.progress import Step, silent
from imubench.recording import Recording, require_known_rig


@dataclass(frozen=True)
class Answer:
    """What explains a recording, and what led to it."""

    start: Beginning
    unseen: tuple[Unseen, ...]
    chosen: Selection | None
    found: Explanation


@dataclass(frozen=True)
class Weight:
    """What the findings of an explanation move, and what speaks against them."""

    said: Explanation  # each finding with what it moves
    without: Mapping[tuple[str, str], Fit]  # the fit without one of the findings, by effect and place
    moves: Moves  # of all together
    doubts: tuple[Doubt, ...]


@remembering()
def diagnose(
    recording: Recording,
    step: Step = silent,
    budget: Budget | None = None,
    tolerance: Pair = TOLERANCE,
    baseline: Diagnosis | None = None,
    rules: Rules | RuleUse | None = None,
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
        rules: those that it does without, or a use of them that sees when each is asked; None: it asks all of them.

    Raises:
        InputError: for a rig of one's own, or a baseline of other sensors.
    """
    clock = perf_counter()
    require_known_rig(recording, "a diagnosis")
    if baseline is not None:
        check_same_sensors(baseline, recording)
    learned = None if baseline is None else Learned.of(baseline)
    work = Work(recording, step, budget or Budget(), tolerance, learned, used(rules))
    with step("hold the sensors against each other"):
        wrong = nonsense(recording)
    if wrong:
        said, shown = diagnosed_without_fit(recording, wrong, clock)
        return replace(said, tolerance=tolerance), shown
    answer = answered(work)
    start, found = answer.start, answer.found
    weight = weight_of(work, found)
    noise = noise_of(work, weight.said)
    sensors: tuple[SensorErrors, ...] = ()
    if answer.chosen:  # one step of the solver: owed whatever the time, for what takes it over
        with step("say what the sensors' own errors are"):
            sensors = own_errors(found.fit, work.recording.imus)
    evidence = evidence_of(work, start, weight.said)
    diagnosis, evidence = concluded(work, start, weight, evidence, noise, answer.unseen)
    return replace(diagnosis, sensors=sensors, seconds=perf_counter() - clock), evidence


def answered(work: Work) -> Answer:
    """Return what explains a recording, of samples at a lower rate where these tell its motion and leave nothing.

    What rings or jumps beneath the noise of single samples shows above the motion, if anywhere.
    """
    answer = answer_of(work, every_sample=False)
    if answer is None:
        work.use.begin_again()
        answer = answer_of(work, every_sample=True)
        assert answer is not None  # of every sample something is said, whatever they leave
    return answer


def answer_of(work: Work, every_sample: bool) -> Answer | None:
    """Return what explains a recording, begun from the fit of the motion to its own samples, or to fewer.

    None where fewer leave something and there is time to ask every sample.
    """
    start = begin(work.recording, work.step, work.budget, work.learned, every_sample)
    fewer = bool(start.first.model.averaging.shares)
    unseen = not_observable(work.recording) if start.finished else not_fitted(work.budget)
    chosen = None if unseen else searched(work, start)
    if fewer and chosen and not work.budget.not_tried and misfit(chosen.fit) > DECLARED_NOISE.most_power:
        return None
    with work.step("weigh and locate what is left"):
        found = explained(work, start, chosen)
    left = bool(found.rest) and not work.budget.not_tried
    return None if fewer and left else Answer(start, unseen, chosen, found)


def searched(work: Work, start: Beginning) -> Selection:
    """Return the effects that were left out."""
    with work.step("find what was left out"), work.budget.part(BUDGET.search, FURTHER):
        chosen = select(start.fit, sharp(start.samples.findings, work.recording), work.use)
    work.budget.missed(*chosen.not_tried)
    return chosen


def weight_of(work: Work, found: Explanation) -> Weight:
    """Return what the findings move, whether that is material, and what speaks against them."""
    without: dict[tuple[str, str], Fit] = {}
    moves: dict[int, dict[str, Move]] = {}
    all_moves: Moves = {}
    against: tuple[Doubt, ...] = ()
    with work.step("see what each finding moves"), work.budget.rest("what each finding moves"):
        for finding, known in moves_of((*found.named, *found.rest), found.fit, found.samples, work.recording, without):
            moves[id(finding)] = known
    named, rest = (with_moves(some, moves, work.tolerance) for some in (found.named, found.rest))
    with work.budget.rest("what all findings move together"):
        all_moves = moves_of_all(found.fit, work.recording, work.tolerance)
    slight = {f"{f.effect}@{f.at}" for f in named if not (f.material and f.confidence >= CONFIDENCE.counts)}
    with work.step("ask whether the halves agree"):
        if any(f.confidence >= CONFIDENCE.counts for f in named) and found.numbers.model.hypotheses:
            against = (not_asked(HALVES_AGREE),)  # as long as the next lines have not answered
            with work.budget.rest(HALVES_AGREE):
                against = work.use.changed(
                    "halves-disagree",
                    (),
                    lambda _: doubts(found.numbers, found.before, found.after, work.tolerance, slight),
                )
    return Weight(replace(found, named=named, rest=rest), without, all_moves, against)


def noise_of(work: Work, said: Explanation) -> dict[str, Noise]:
    """Return the noise that counts by triple, and how it is known."""
    levels = fit_summary.of_recording(said.before)
    noise = fit_summary.noise_of(levels, work.recording, said.samples.rest)
    return noise if work.learned is None else work.learned.known(noise)


def evidence_of(work: Work, start: Beginning, said: Explanation) -> Evidence:
    """Return what is shown beside the diagnosis, but for its simulations."""
    again = believed(fit_summary.replayed(said.numbers, said.fit), said.named, start.first.model.masks)
    knots = start.fit.model.tracks.knots.count
    seen = "samples at a lower rate" if start.fit.model.averaging.shares else "every sample"
    return Evidence(
        work.recording,
        said.traces,
        fit_summary.played(to_the_ends(again, work.recording)),
        fit_summary.mounts(again),
        fit_summary.of_recording(said.before),
        motion_before=fit_summary.played(to_the_ends(start.first, work.recording)) if said.named else None,
        notes=(
            f"A spline motion with {knots} knots and the mounts were fitted to {seen}.",
            "Every effect was scored; the best were fitted exactly and judged on blocks of 5 s that they had not seen.",
            *said.samples.notes,
            *fit_summary.beside_motion(said.fit),
        ),
        fired=work.use.fired,
        decisions=tuple(work.use.decisions),
    )


def concluded(
    work: Work,
    start: Beginning,
    weight: Weight,
    evidence: Evidence,
    noise: Mapping[str, Noise],
    unseen: tuple[Unseen, ...],
) -> tuple[Diagnosis, Evidence]:
    """Return the diagnosis, but for the sensors' errors and the time it took, and the evidence with its simulations."""
    said, budget, recording = weight.said, work.budget, work.recording
    named, rest, before, after = said.named, said.rest, said.before, said.after
    nobody = [name for name, level in noise.items() if level.source == NOT_KNOWN]
    with work.step("play the simulations beside the recording"):
        best = believed(said.numbers, said.named, start.first.model.masks)
        others = weight.without if best is said.numbers else {}  # these have in them what is not likely
        simulation, evidence, acting = judged_by_simulation(
            evidence, start.first, best, (*named, *rest), others, budget
        )
    verdict: Verdict = "unobservable" if unseen else verdict_of(named, rest, nobody, bool(weight.doubts))
    if said.partly:
        verdict, unseen = verdict_when_stopped(named, rest, after, nobody, bool(weight.doubts))
    if nobody and verdict == "partly explained":
        unseen = (*unseen, noise_not_shown(nobody))
    quality = FitQuality((before.left_out, after.left_out))
    if named or rest:
        with budget.rest("channels left out"):
            quality = FitQuality(quality.heldout, left_out_change(before, after))
    where = said.where
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
        said.refused,
        quality,
        "",
        0.0,
        unseen,
        permuted((*named, *rest), recording),
        budget.stopped,
        tuple(budget.not_tried),
        dict(noise),
        work.tolerance,
        baseline=None if work.learned is None else work.learned.record,
        doubts=weight.doubts if verdict == "partly explained" else (),
        simulation=simulation,
        moves=weight.moves,
    )
    return diagnosis, evidence


__all__ = ["diagnose"]
