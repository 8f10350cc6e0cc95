"""The main job: simulate, observe, estimate, score, write; and the same from a recording on disk."""

from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from imubench.answers import (
    beside_axes,
    beside_declared_vector,
    declared_axes,
    estimate_as_dict,
    failure_as_dict,
    moved,
    score_as_dict,
    write_json,
)
from imubench.atomic import atomic_directory
from imubench.attempt import attempted
from imubench.band import banded, independent
from imubench.errors import InputError
from imubench.estimate import Estimate, Failed
from imubench.estimators import Estimator
from imubench.estimators.banded import BLOCKS, explained
from imubench.format1 import write_recording
from imubench.inputs.files import below, what_is
from imubench.models.tree import rig_tree
from imubench.plugins import find_estimator, is_outside
from imubench.progress import Step, silent
from imubench.recording import Recording, require_known_rig
from imubench.reference import Reference
from imubench.reference_axes import reference_axes
from imubench.score import Score, score
from imubench.simulation import AS_IT_IS, Changes, effects_of, simulate
from imubench.sources import Source, read
from imubench.truth import Truth

if TYPE_CHECKING:  # what logs, replays and corrects is imported where it is done: a refusal needs none of it
    from imubench.correction.corrected import Done
    from imubench.diagnosis.result import Diagnosis

TRACE_FILE = "failure.txt"


@dataclass(frozen=True)
class Run:
    """A simulated experiment from end to end."""

    recording: Recording
    truth: Truth
    estimate: Estimate | None
    score: Score | None
    failed: Failed | None = None  # why there is no estimate by an estimator that was asked for


class NoEstimateError(Exception):
    """An estimator from outside, or one that took too long, made no estimate; what there is to say of it is written."""

    def __init__(self, failed: Failed) -> None:
        super().__init__(failed.why)
        self.failed = failed


def estimate(name: str | Estimator, recording: Recording, band: float | None = None) -> Estimate:
    """Return what an estimator makes of a recording, or of what its IMUs read below `band` Hz (docs/band.md).

    Args:
        name: of an estimator, as `find_estimator` takes it; or an estimator.
        recording: what it is given.
        band: Hz. Filtered samples are correlated. An estimator that takes them for independent states too small a
            covariance, which is divided by the part of them that white noise leaves independent.

    Raises:
        InputError: for an unknown estimator, a recording that it cannot take, or one whose rate is too low for the
            band. An error in an estimator from outside comes through as it is.
    """
    estimator = find_estimator(name) if isinstance(name, str) else name
    taken = recording if band is None else banded(recording, band)
    return _of_band(estimator.estimate(taken), recording, band)


def estimate_or_failure(
    estimator: Estimator, recording: Recording, band: float | None = None, seconds: float | None = None
) -> Estimate | Failed:
    """Return what an estimator makes of a recording; of one from outside, or with a limit in s, how it failed instead.

    The errors of our own estimators are raised: bad input is told in one line, and a defect is reported.
    """
    if seconds is None and not is_outside(estimator):
        return estimate(estimator, recording, band)
    found = attempted(estimator, recording if band is None else banded(recording, band), seconds)
    return found if isinstance(found, Failed) else _of_band(found, recording, band)


def _of_band(answer: Estimate, recording: Recording, band: float | None) -> Estimate:
    """Return an estimate from samples below `band` Hz with the covariance that these allow."""
    if band is None:
        return answer
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
    time_limit: float | None = None,
    changes: Changes = AS_IT_IS,
) -> Run:
    """Simulate, estimate, score and log a scenario, or the model/ folder of a diagnosis, into the folder `out`.

    The estimator sees what the IMUs read below `band` Hz, or all of it; what is written and logged is not filtered.
    Writes score.json, recording/ (format 1, with the truth's reference.csv) and run.rrd. Without
    an estimator for the scenario's rig, score.json says so; and so it does where one from outside fails, or has not
    answered after `time_limit` s. Its trace is then in failure.txt.
    """
    replayed = what_is(Path(scenario)) == "a folder" and _is_model(Path(scenario))
    if replayed and changes:
        raise InputError(f"{scenario}: expected a scenario for another IMU, duration or effect, got a diagnosis' model")
    name = estimator or (None if replayed else _own_estimator(scenario))
    by = None if name is None else find_estimator(name)
    with atomic_directory(out, [Path(scenario)] if replayed else ()) as folder:
        with step(f"simulate {scenario}"):
            if replayed:
                from imubench.diagnosis.simulation.model_folder import replay

                drawn = replay(Path(scenario), np.random.default_rng(seed))
            else:
                drawn = simulate(scenario, seed, changes)
        facts = {"format": 1, "scenario": scenario, "seed": seed, **_changes_as_dict(scenario, seed, changes)}
        return _run_into(folder, facts, drawn, by, step, band, time_limit)


def _is_model(folder: Path) -> bool:
    from imubench.diagnosis.simulation.model_folder import is_model

    return is_model(folder)


def _own_estimator(scenario: str) -> str | None:
    """Return the estimator that a scenario takes by default."""
    from imubench.scenarios import find_scenario

    return find_scenario(scenario).estimator


def _run_into(
    folder: Path,
    facts: dict[str, object],
    drawn: tuple[Recording, Truth],
    estimator: Estimator | None,
    step: Step,
    band: float | None,
    time_limit: float | None,
) -> Run:
    recording, truth = drawn
    answer = judged = failed = None
    if estimator is not None:
        with step(f"estimate with {estimator.name}"):
            found = estimate_or_failure(estimator, recording, band, time_limit)
            failed = found if isinstance(found, Failed) else None
            answer = None if isinstance(found, Failed) else found
            judged = None if answer is None else score(answer, truth)
    with step("write and log"):
        write_recording(recording, folder / "recording", reference_of(truth, recording))
        write_json(folder / "score.json", facts | _outcome(answer, judged, failed))
        _write_trace(folder, failed)
        from imubench.log import log_run

        log_run(folder / "run.rrd", recording, truth, answer, judged)
    return Run(recording, truth, answer, judged, failed)


@dataclass(frozen=True)
class OnDisk:
    """An estimate on a recording from disk, and how it compares with what else is known of the mounts."""

    recording: Recording
    estimate: Estimate
    beside_reference: Score | None
    beside_declared: Score | None
    diagnosis: "Diagnosis | None" = None  # that the recording was corrected with
    done: "tuple[Done, ...]" = ()  # about each of its findings
    uncorrected: Estimate | None = None  # of the recording as it came; None: none was corrected, or it takes it not


def estimate_on_disk(
    name: str,
    source: Source,
    out: Path,
    step: Step = silent,
    diagnosis: Path | None = None,
    band: float | None = None,
    time_limit: float | None = None,
) -> OnDisk:
    """Estimate on a recording in format 1, or DIR#17 of a dataset; write estimate.json and run.rrd into `out`.

    With the `diagnosis` of that recording (its folder) what was found is taken out first, see docs/correct-with.md;
    what the estimator then took is written too, as corrected/. With a `band` in Hz both IMUs are filtered after that.

    Raises:
        InputError: for bad input; nothing is written.
        NoEstimateError: an estimator from outside fails, or one has not answered after `time_limit` s; estimate.json
            says so, and its trace is in failure.txt.
    """
    estimator = find_estimator(name)
    inputs = [Path(given) for given in (source, diagnosis) if given is not None]
    with atomic_directory(out, inputs) as target:
        done = _estimate_into(target, estimator, source, step, diagnosis, band, time_limit)
    if isinstance(done, Failed):
        raise NoEstimateError(done)
    return done


def _estimate_into(
    target: Path,
    estimator: Estimator,
    source: Source,
    step: Step,
    diagnosis: Path | None,
    band: float | None,
    time_limit: float | None,
) -> OnDisk | Failed:
    told = None if diagnosis is None else _diagnosis(diagnosis)
    with step(f"read {source}"):
        recording, reference = read(source)
    done: tuple[Done, ...] = ()
    uncorrected = None
    if diagnosis is not None and told is not None:
        with suppress(InputError), step(f"estimate with {estimator.name} on the recording as it came"):
            came = estimate_or_failure(estimator, recording, band, time_limit)
            uncorrected = None if isinstance(came, Failed) else came
        recording, done = _without(recording, told, Path(diagnosis), step)
    with step(f"estimate with {estimator.name}"):
        answer = estimate_or_failure(estimator, recording, band, time_limit)
    if isinstance(answer, Failed):
        of = {"format": 1, "recording": recording.name, "rig": recording.rig}
        write_json(target / "estimate.json", of | failure_as_dict(answer))
        _write_trace(target, answer)
        return answer
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
        from imubench.log import log_run

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


def _diagnosis(path: Path) -> "Diagnosis":
    from imubench.diagnosis.result_read import read_diagnosis

    return read_diagnosis(path)


def _without(recording: Recording, told: "Diagnosis", path: Path, step: Step) -> "tuple[Recording, tuple[Done, ...]]":
    """Return a recording without what its diagnosis at `path` found, and what was done about each finding."""
    from imubench.correction.corrected import corrected
    from imubench.diagnosis.simulation.model_folder import check_same

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
        joint_position=None if rig_tree(truth.rig).loose else truth.segments[0].position[rows],
    )


def _changes_as_dict(scenario: str, seed: int, changes: Changes) -> dict[str, object]:
    """Return what a run has changed of its scenario, as plain numbers and text; nothing where it is as it is."""
    if not changes:
        return {}
    given = {"profile": changes.imu, "duration": changes.seconds, "effects": effects_of(scenario, seed, changes)}
    return {"changes": {key: value for key, value in given.items() if value not in (None, [])}}


def _outcome(answer: Estimate | None, judged: Score | None, failed: Failed | None) -> dict[str, object]:
    if failed is not None:
        return failure_as_dict(failed) | {"estimate": None}
    if answer is None or judged is None:
        return {"estimate": None, "why": "no estimator was asked for, and the scenario names none"}
    return {**score_as_dict(judged), "status": answer.status, "estimate": estimate_as_dict(answer)}


def _write_trace(folder: Path, failed: Failed | None) -> None:
    if failed is not None and failed.trace:
        (folder / TRACE_FILE).write_text(failed.trace, encoding="utf-8", errors="backslashreplace")


__all__ = [
    "TRACE_FILE",
    "Changes",
    "NoEstimateError",
    "OnDisk",
    "Run",
    "estimate",
    "estimate_on_disk",
    "estimate_or_failure",
    "reference_of",
    "run_scenario",
    "simulate",
]
