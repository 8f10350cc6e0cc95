"""From a recording to a diagnosis: fit the motion, weigh what is left, locate it, say what it is."""

from dataclasses import replace
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from imubench.diagnosis import gather
from imubench.diagnosis.coherence import follows_motion
from imubench.diagnosis.equations import equation_rows
from imubench.diagnosis.evidence import Evidence
from imubench.diagnosis.findings import findings, rejected
from imubench.diagnosis.fit import Fit, solve
from imubench.diagnosis.kinematics import Rig
from imubench.diagnosis.left_out import left_out_change
from imubench.diagnosis.noise import declared, declared_by, fit_with_noise
from imubench.diagnosis.priors import START_SMOOTH
from imubench.diagnosis.regressors import regressors
from imubench.diagnosis.result import UNKNOWN, Diagnosis, Finding, FitQuality, Unseen, Verdict
from imubench.diagnosis.samples import Sampled, heard, sampled
from imubench.diagnosis.select import RELATED, select
from imubench.diagnosis.start import blind_start, model_of
from imubench.diagnosis.stops import settled_between, stop_of
from imubench.diagnosis.unknown import unknowns
from imubench.diagnosis.where import locate
from imubench.progress import Step, silent
from imubench.recording import Recording

START_NOISE = {"gyro": 0.3, "accel": 1.0, "angle": 0.01, "position": 0.01, "rotation": 0.02}  # loose: rad/s, m/s^2, ...
LOOSE_EQUATION = 1e4  # of its std: the sensors say what moves before the equation of motion is asked
FREER = 8.0  # times the roughness of a motion that may be held too smooth
UNRELATED = 1.0  # of follows_motion: no more than by chance
KNOCKING = ("end_stop", "joint_play")  # what knocks by itself
STILL = 0.05  # rad/s RMS, under which a sensor does not turn
SHORT = 5.0  # s
MUCH = 0.1  # of what a name is worth on held-out data
DOUBTFUL = 0.6  # the confidence at most of a name beside an unknown: of 7 in 178 blind trials 2 were right


def diagnose(recording: Recording, step: Step = silent) -> tuple[Diagnosis, Evidence]:
    """Return what a recording says about the model it was declared with, and what shows it."""
    begin = perf_counter()
    with step("check the samples"):
        samples = sampled(recording)
    with step("fit the motion"):
        known = heard(recording, samples.findings)
        fit = first = nominal_fit(known, samples.masks)
        if stop := stop_of(first, samples):
            known = replace(known, free_swings=stop.swings(known.free_swings))
            fit = nominal_fit(known, stop.masks(first, samples.masks))
            samples = settled_between(stop, fit).told(samples)
    unseen = missing(recording)
    with step("find what was left out"):
        chosen = select(fit) if not unseen else None
    told, now = declared_by(recording), declared(fit.model)
    with step("weigh and locate what is left"):
        before = gather.weighed(first, told)
        where = locate(gather.traces(before), regressors(first))
        rest, best = unknowns(chosen.fit, where) if chosen else ((), fit)
        rounded = {f.at for f in samples.findings if f.effect == "quantisation"}
        rest = tuple(f for f in rest if f.at not in rounded)  # rounding goes with the signal, and is said already
        noises = tuple(f for f in rest if f.effect != UNKNOWN)
        rest = tuple(f for f in rest if f.effect == UNKNOWN)
        now |= {f"{f.at}.{f.effect.removesuffix('_noise')}": float(f.parameters["std"].value) for f in noises}
        after = gather.weighed(best, now)
        kept = {(h.effect.name, h.at) for h in best.model.hypotheses}
        fitted = tuple(f for f in (findings(chosen) if chosen else ()) if (f.effect, f.at) in kept)
        named = with_samples((*beside(fitted, rest), *noises), samples)
        traces = gather.traces(before, after if named or rest else None)
    evidence = Evidence(
        recording,
        traces,
        gather.played(best),
        gather.mounts(best),
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
        rejected(chosen) if chosen else (),
        FitQuality(held, left_out_change(before, after)) if named or rest else FitQuality(held),
        "",
        perf_counter() - begin,
        unseen,
    )
    return diagnosis, evidence


def with_samples(fitted: tuple[Finding, ...], samples: Sampled) -> tuple[Finding, ...]:
    """Return what the fit found, and what the raw samples show that it did not find itself."""
    same = {(f.effect, f.at) for f in fitted}
    knocking = any(f.effect in KNOCKING for f in fitted)
    raw = samples.findings if knocking else (*samples.findings, *samples.unless_stopped)
    if knocking:
        raw = tuple(f for f in raw if f.effect != "impacts")
    return (*fitted, *(f for f in raw if (f.effect, f.at) not in same))


def beside(named: tuple[Finding, ...], rest: tuple[Finding, ...]) -> tuple[Finding, ...]:
    """Return named findings, doubted where something without a name at their place is worth much: it may be all."""

    def strange(f: Finding) -> bool:
        return any(u.at == f.at and u.heldout_gain.value > MUCH * f.heldout_gain.value for u in rest)

    return tuple(replace(f, confidence=min(f.confidence, DOUBTFUL)) if strange(f) else f for f in named)


def verdict_of(named: tuple[Finding, ...], rest: tuple[Finding, ...]) -> Verdict:
    """Return the verdict that goes with findings by name and without one."""
    if named:
        return "partly explained" if rest else "explained"
    return "unexplained" if rest else "no mismatch"


def nominal_fit(recording: Recording, masks: dict[str, NDArray[np.bool_]] | None = None) -> Fit:
    """Return the fit of the model as it was declared, noise levels estimated; `masks` says which samples count."""
    model = replace(model_of(recording), masks=masks or None)
    model, state, anchor = blind_start(model)
    noise = {r.name: START_NOISE[r.name.split(".")[1]] for r in model.measured(state)}
    noise |= {f"smooth.{name}": START_SMOOTH[name] for name in model.tracks.widths if name in START_SMOOTH}
    laws = {r.name: LOOSE_EQUATION for r in equation_rows(model, state)}
    noise |= laws
    begun = solve(model, state, noise, anchor, enough=1e-3)
    noise |= declared(model)
    fit = fit_with_noise(model, begun.state, noise, anchor, motion=True)
    fit = freed(fit)
    if not laws:
        return fit
    sensors = {name: std for name, std in fit.noise.items() if name not in laws}
    fit = fit_with_noise(model, fit.state, sensors | dict.fromkeys(laws, 1.0), anchor, rounds=4, only=laws.keys())
    return fit


def freed(fit: Fit) -> Fit:
    """Return the fit with its motion held less smooth, where that is all that its residuals had against it.

    One roughness for rests and quick strokes may be too small for the strokes; what a sensor does of its own shows
    against the other sensors, however rough the motion may be.
    """
    if max(follows_motion(fit).values(), default=0.0) < RELATED:
        return fit
    noise = {name: std * (FREER if name.startswith("smooth.") else 1.0) for name, std in fit.noise.items()}
    freer = fit_with_noise(fit.model, fit.state, noise, fit.anchor)
    return freer if max(follows_motion(freer).values()) < UNRELATED else fit


def missing(recording: Recording) -> tuple[Unseen, ...]:
    """Return what the recording is too poor in sensors, too still or too short to show."""
    out = []
    rig = Rig.of(recording)
    unknown = 3 * rig.turns + 3 * rig.moves + rig.hinge
    poses = sum(3 * (p.position is not None) + 3 * (p.quaternion is not None) for p in recording.poses)
    channels = 6 * len(recording.imus) + len(recording.encoders) + poses
    if channels <= unknown and not recording.free_swings:
        out.append(
            Unseen(
                f"any mismatch: {channels} channels leave nothing to check once {unknown} motions are found from them",
                "the same with a second IMU, an encoder or a measured pose, or a declared free swing",
            )
        )
    stamps = [i.time for i in recording.imus] + [e.time for e in recording.encoders] + [p.time for p in recording.poses]
    seconds = max(t[-1] for t in stamps) - min(t[0] for t in stamps)
    if seconds < SHORT:
        out.append(Unseen(f"anything that takes longer than {seconds:.1f} s to show", "20 s or more of motion"))
    if recording.imus and all(np.sqrt(np.mean(np.sum(i.gyro**2, axis=1))) < STILL for i in recording.imus):
        out.append(Unseen("mounts, scales and everything that shows with motion", "turns about every axis, 2 rad/s"))
    return tuple(out)
