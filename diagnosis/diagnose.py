"""From a recording to a diagnosis: fit the motion, weigh what is left, locate it, say what it is."""

from collections.abc import Collection, Sequence
from time import perf_counter

from imubench.diagnosis import gather
from imubench.diagnosis.begin import begun
from imubench.diagnosis.by_size import named_by_size, with_equals
from imubench.diagnosis.equalled import with_likes, with_refused
from imubench.diagnosis.evidence import Evidence
from imubench.diagnosis.findings import findings, rejected
from imubench.diagnosis.fit import Fit
from imubench.diagnosis.left_out import left_out_change
from imubench.diagnosis.loud import refuted
from imubench.diagnosis.noise import declared, declared_by
from imubench.diagnosis.nominal import certain
from imubench.diagnosis.rattles import rattling
from imubench.diagnosis.regressors import regressors
from imubench.diagnosis.result import UNKNOWN, Diagnosis, Finding, FitQuality, Verdict
from imubench.diagnosis.rounded import beside_rounding, sharp
from imubench.diagnosis.select import Selection, select
from imubench.diagnosis.series import named_by_law
from imubench.diagnosis.struck import struck_again
from imubench.diagnosis.unknown import Unknowns, unknowns
from imubench.diagnosis.verdict import beside, beside_hum, missing, surest_first, verdict_of, with_samples
from imubench.diagnosis.where import locate
from imubench.effects.effect import Effect
from imubench.progress import Step, silent
from imubench.recording import Recording


def diagnose(recording: Recording, step: Step = silent) -> tuple[Diagnosis, Evidence]:
    """Return what a recording says about the model it was declared with, and what shows it."""
    clock = perf_counter()
    start = begun(recording, step)
    samples, first, fit = start.samples, start.first, start.fit
    unseen = missing(recording)
    with step("find what was left out"):
        chosen = select(fit, rounding=sharp(samples.findings, recording)) if not unseen else None
    stated, now = declared_by(recording), declared(fit.model)
    with step("weigh and locate what is left"):
        before = gather.weighed(first, stated, samples.white)
        where = locate(gather.traces(before), regressors(first))
        strange = unknowns(chosen.fit, where) if chosen else Unknowns((), fit, ())
        for naming in (named_by_law, named_by_size):
            if chosen and (told := naming(chosen, strange)) is not chosen:
                chosen, strange = told, unknowns(told.fit, where)
        rest, best = with_equals(strange).findings, strange.fit
        samples = samples.without(refuted(samples.findings, best, {f.at for f in rest}))
        rest = not_told(rest, samples.findings)
        noises = tuple(f for f in rest if f.effect != UNKNOWN)
        rest = tuple(f for f in rest if f.effect == UNKNOWN)
        now |= {f"{f.at}.{f.effect.removesuffix('_noise')}": float(f.parameters["std"].value) for f in noises}
        after = gather.weighed(best, now)
        kept = {(h.effect.name, h.at) for h in best.model.hypotheses}
        plain = numbered(chosen, kept) or best
        fitted = tuple(f for f in (findings(chosen, recording) if chosen else ()) if (f.effect, f.at) in kept)
        refused = rejected(chosen) if chosen else ()
        rest = with_refused(with_likes(rest, fitted), fitted, refused)
        noises = beside_hum(noises, (*fitted, *samples.findings))
        named = with_samples((*beside(fitted, rest, strange.doubted, certain(fit.model)), *noises), samples, rest)
        named += struck_again(best, samples.struck, named, chosen.springs_refused) if chosen else ()
        named = surest_first(rattling(beside_rounding(named, recording, samples.humming), recording))
        traces = gather.traces(before, after if named or rest else None)
    evidence = Evidence(
        recording,
        traces,
        gather.played(plain),
        gather.mounts(plain),
        before.levels,
        motion_before=gather.played(first) if named else None,
        notes=(
            f"A spline motion with {fit.model.tracks.knots.count} knots and the mounts were fitted to every sample.",
            "Every effect was scored; the best were fitted exactly and judged on blocks of 5 s that they had not seen.",
            *samples.notes,
        ),
    )
    verdict: Verdict = "unobservable" if unseen else verdict_of(named, rest)
    held = (before.left_out, after.left_out)
    diagnosis = Diagnosis(
        recording.name,
        recording.rig,
        verdict,
        (before.misfit, after.misfit),
        where,
        (*named, *rest),
        refused,
        FitQuality(held, left_out_change(before, after)) if named or rest else FitQuality(held),
        "",
        perf_counter() - clock,
        unseen,
    )
    return diagnosis, evidence


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
