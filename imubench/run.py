"""The main job: simulate, observe, estimate, score, write; and the same from a recording on disk."""

from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from imubench.answers import (
    beside_axes,
    beside_declared_vector,
    declared_axes,
    estimate_as_dict,
    moved,
    score_as_dict,
    write_json,
)
from imubench.atomic import atomic_directory
from imubench.band import banded, independent
from imubench.diagnosis.corrected import Done, corrected
from imubench.diagnosis.model_folder import check_same, is_model, replay
from imubench.diagnosis.result import Diagnosis
from imubench.diagnosis.result_read import read_diagnosis
from imubench.errors import InputError, unknown
from imubench.estimate import Estimate
from imubench.estimators import ESTIMATORS
from imubench.estimators.banded import BLOCKS, explained
from imubench.format1 import write_recording
from imubench.inputs.files import below
from imubench.log import log_run
from imubench.progress import Step, silent
from imubench.recording import Recording, require_known_rig
from imubench.reference import Reference
from imubench.reference_axes import reference_axes
from imubench.scenarios import SCENARIOS
from imubench.score import Score, score
from imubench.sim.imu_model import observe
from imubench.sim.profiles import profile
from imubench.sources import Source, read
from imubench.truth import Truth


@dataclass(frozen=True)
class Run:
    """A simulated experiment from end to end."""

    recording: Recording
    truth: Truth
    estimate: Estimate | None
    score: Score | None


def simulate(scenario: str, seed: int = 0) -> tuple[Recording, Truth]:
    """Return the recording of a scenario, and its truth; the same seed gives the same numbers."""
    if scenario not in SCENARIOS:
        raise unknown("scenario", scenario, SCENARIOS)
    plan = SCENARIOS[scenario]
    playing, observing = np.random.default_rng(seed).spawn(2)
    experiment = plan.play(playing)
    name = f"{scenario}-{seed}"
    return observe(experiment.truth, profile(plan.profile), observing, name, experiment.declared), experiment.truth


def estimate(name: str, recording: Recording, band: float | None = None) -> Estimate:
    """Return what an estimator makes of a recording, or of what its IMUs read below `band` Hz (docs/band.md).

    Filtered samples are correlated. An estimator that takes them for independent states too small a covariance, which
    is divided by the part of them that white noise leaves independent. Raises `InputError` for an unknown estimator, a
    recording that it cannot take, or one whose rate is too low for the band.
    """
    if name not in ESTIMATORS:
        raise unknown("estimator", name, ESTIMATORS)
    if band is None:
        return ESTIMATORS[name].estimate(recording)
    answer = ESTIMATORS[name].estimate(banded(recording, band))
    part = 1.0 if BLOCKS in answer.details else independent(recording, band)
    details = {**answer.details, "filtered_below": band, "independent_samples": part}
    covariance = None if answer.covariance is None else answer.covariance / part
    return replace(answer, covariance=covariance, details=details)


def run_scenario(
    scenario: str,
    out: Path,
    estimator: str | None = None,
    seed: int = 0,
    step: Step = silent,
    band: float | None = None,
) -> Run:
    """Simulate, estimate, score and log a scenario, or the model/ folder of a diagnosis, into the folder `out`.

    The estimator sees what the IMUs read below `band` Hz, or all of it; what is written and logged is not filtered.
    Writes score.json, recording/ (format 1, with the truth's reference.csv) and run.rrd. Without
    an estimator for the scenario's rig, score.json says so.
    """
    replayed = is_model(Path(scenario))
    if scenario not in SCENARIOS and not replayed:
        raise unknown("scenario", scenario, SCENARIOS)
    estimator = estimator or (None if replayed else SCENARIOS[scenario].estimator)
    if estimator is not None and estimator not in ESTIMATORS:
        raise unknown("estimator", estimator, ESTIMATORS)
    with atomic_directory(out, [Path(scenario)] if replayed else ()) as folder:
        return _run_into(folder, scenario, replayed, estimator, seed, step, band)


def _run_into(
    folder: Path, scenario: str, replayed: bool, estimator: str | None, seed: int, step: Step, band: float | None
) -> Run:
    with step(f"simulate {scenario}"):
        recording, truth = replay(Path(scenario), np.random.default_rng(seed)) if replayed else simulate(scenario, seed)
    answer = judged = None
    if estimator is not None:
        with step(f"estimate with {estimator}"):
            answer = estimate(estimator, recording, band)
            judged = score(answer, truth)
    with step("write and log"):
        write_recording(recording, folder / "recording", reference_of(truth, recording))
        write_json(folder / "score.json", _score_file(scenario, seed, answer, judged))
        log_run(folder / "run.rrd", recording, truth, answer, judged)
    return Run(recording, truth, answer, judged)


@dataclass(frozen=True)
class OnDisk:
    """An estimate on a recording from disk, and how it compares with what else is known of the mounts."""

    recording: Recording
    estimate: Estimate
    beside_reference: Score | None
    beside_declared: Score | None
    diagnosis: Diagnosis | None = None  # that the recording was corrected with
    done: tuple[Done, ...] = ()  # about each of its findings
    uncorrected: Estimate | None = None  # of the recording as it came; None: none was corrected, or it takes it not


def estimate_on_disk(
    name: str,
    source: Source,
    out: Path,
    step: Step = silent,
    diagnosis: Path | None = None,
    band: float | None = None,
) -> OnDisk:
    """Estimate on a recording in format 1, or DIR#17 of a dataset; write estimate.json and run.rrd into `out`.

    With the `diagnosis` of that recording (its folder) what was found is taken out first, see docs/correct-with.md;
    what the estimator then took is written too, as corrected/. With a `band` in Hz both IMUs are filtered after that.
    """
    if name not in ESTIMATORS:
        raise unknown("estimator", name, ESTIMATORS)
    inputs = [Path(given) for given in (source, diagnosis) if given is not None]
    with atomic_directory(out, inputs) as target:
        return _estimate_into(target, name, source, step, diagnosis, band)


def _estimate_into(
    target: Path, name: str, source: Source, step: Step, diagnosis: Path | None, band: float | None
) -> OnDisk:
    told = None if diagnosis is None else read_diagnosis(diagnosis)
    with step(f"read {source}"):
        recording, reference = read(source)
    done: tuple[Done, ...] = ()
    uncorrected = None
    if diagnosis is not None and told is not None:
        with suppress(InputError), step(f"estimate with {name} on the recording as it came"):
            uncorrected = estimate(name, recording, band)
        recording, done = _without(recording, told, Path(diagnosis), step)
    with step(f"estimate with {name}"):
        answer = estimate(name, recording, band)
    seen, declared = reference_axes(recording, reference), declared_axes(recording)
    result = OnDisk(
        recording,
        answer,
        beside_axes(answer, recording, seen),
        beside_axes(answer, recording, declared) or beside_declared_vector(answer, recording),
        told,
        done,
        uncorrected,
    )
    with step("write and log"):
        content = {"format": 1, "recording": recording.name, "rig": recording.rig, **estimate_as_dict(answer)}
        words = explained(answer)
        if words:
            content["band"] = words
        for key, beside in (("reference", result.beside_reference), ("declared_mounts", result.beside_declared)):
            if beside is not None:
                content[f"beside_{key}"] = score_as_dict(beside)["figures"]
        if told is not None:
            findings = [{"effect": d.effect, "at": d.at, "done": d.what} for d in done]
            content["with"] = {"verdict": told.verdict, "findings": findings}
            if uncorrected is not None and (by := moved(uncorrected, answer)) is not None:
                change = {answer.quantity: {"value": by[0].tolist(), "unit": by[1]}}
                content["with"] |= {"moved": change, "status_as_it_came": uncorrected.status}
            write_recording(recording, target / "corrected", reference)
        write_json(target / "estimate.json", content)
        log_run(
            target / "run.rrd",
            recording,
            estimate=answer,
            score=result.beside_reference or result.beside_declared,
            true_axes=declared if seen is None else seen,
            axes_from="declared" if seen is None else "reference",
            reference=reference,
        )
    return result


def _without(recording: Recording, told: Diagnosis, path: Path, step: Step) -> tuple[Recording, tuple[Done, ...]]:
    """Return a recording without what its diagnosis at `path` found, and what was done about each finding."""
    require_known_rig(recording, "a correction by its diagnosis")
    folder = path if path.is_dir() else path.parent
    if told.model:
        model = below(folder, told.model, f"{path}, key 'model'", "a file of the diagnosis")
        check_same(model.parent, recording)
    try:
        without = corrected(recording, told, step)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    return without.recording, without.done


def reference_of(truth: Truth, recording: Recording) -> Reference:
    """Return the truth at the first IMU's nominal rate, as a laboratory's reference would have it."""
    rate = recording.imus[0].rate if recording.imus else 100.0
    every = max(1, round(1.0 / (rate * (truth.time[1] - truth.time[0]))))
    rows = slice(None, None, every)
    if truth.time.size < 2:
        raise InputError(f"truth: expected at least two samples, got {truth.time.size}")
    return Reference(
        time=truth.time[rows],
        hinge_angle=None if truth.joint_angle is None else truth.joint_angle[rows],
        quaternion1=truth.segments[0].quaternion[rows],
        quaternion2=truth.segments[1].quaternion[rows] if len(truth.segments) > 1 else None,
        joint_position=None if truth.rig == "free" else truth.segments[0].position[rows],
    )


def _score_file(scenario: str, seed: int, answer: Estimate | None, judged: Score | None) -> dict[str, object]:
    content: dict[str, object] = {"format": 1, "scenario": scenario, "seed": seed}
    if answer is None or judged is None:
        return content | {"estimate": None, "why": "no estimator was asked for, and the scenario names none"}
    return content | {**score_as_dict(judged), "status": answer.status, "estimate": estimate_as_dict(answer)}
