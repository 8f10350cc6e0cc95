"""A recording on disk to a folder with everything about its diagnosis."""

from dataclasses import dataclass, replace
from pathlib import Path
from time import process_time
from typing import Any

from imubench.answers import write_json
from imubench.atomic import atomic_directory
from imubench.correction.estimates import estimates
from imubench.correction.export import write_model
from imubench.diagnosis.budget import Budget
from imubench.diagnosis.config.verdict import BUDGET
from imubench.diagnosis.evidence import Estimated, Evidence
from imubench.diagnosis.pipeline import diagnose
from imubench.diagnosis.report import Paths, page
from imubench.diagnosis.report.rerun_log import log_diagnosis
from imubench.diagnosis.report.shares import with_shares
from imubench.diagnosis.result import TOLERANCE, Diagnosis, Pair
from imubench.diagnosis.result_file import FILE_NAME, as_dict
from imubench.diagnosis.result_read import read_diagnosis
from imubench.diagnosis.sensor_errors.baseline import check_same_sensors, check_usable
from imubench.diagnosis.verdict.reference_motion import with_reference_errors
from imubench.errors import InputError
from imubench.progress import Step, silent
from imubench.recording import Recording
from imubench.reference import Reference
from imubench.sources import read

REPORT, LOG, MODEL, BASELINE = "report.html", "diagnosis.rrd", "model", "baseline"


STEP_BEGINNINGS = (
    "read ",
    "hold the sensors against each other",
    "check the samples",
    "fit the motion",
    "find what was left out",
    "weigh and locate what is left",
    "see what each finding moves",
    "ask whether the halves agree",
    "say what the sensors' own errors are",
    "play the simulations beside the recording",
    "estimate with and without what was found",
    "write the model",
    "write the Rerun file",
    "draw the report",
)
"""How the steps of a diagnosis begin, in their order."""


@dataclass(frozen=True)
class Done:
    """A diagnosis, and what shows it."""

    diagnosis: Diagnosis
    evidence: Evidence


def diagnose_on_disk(
    folder: Path,
    out: Path,
    step: Step = silent,
    time_limit: float = BUDGET.limit_s,
    tolerance: Pair = TOLERANCE,
    baseline: Path | None = None,
) -> Done:
    """Diagnose a recording in format 1 and write diagnosis.json, report.html, diagnosis.rrd and model/ into `out`.

    The reference, if there is one, only judges. After `time_limit` s of processor time what is known by then is
    written. A finding that moves nothing by `tolerance` (deg, mm) is not material. `baseline` is a diagnosis of the
    same sensors, or a recording: then that is diagnosed first, into `out`/baseline, in at most `BUDGET.baseline` of the
    time.
    """
    began = process_time()
    inputs = [Path(folder)] if baseline is None else [Path(folder), Path(baseline)]
    with atomic_directory(out, inputs) as target:
        with step(f"read {folder}"):
            recording, reference = read(folder)
        told = None
        if baseline is not None:
            told = _told(Path(baseline), recording, target / BASELINE, step, BUDGET.baseline * time_limit, tolerance)
        left = Budget(time_limit, began)
        return _written(recording, reference, target, step, left, tolerance, told, Paths(str(folder), str(out)))


def diagnosed(
    recording: Recording,
    reference: Reference | None = None,
    step: Step = silent,
    budget: Budget | None = None,
    tolerance: Pair = TOLERANCE,
    baseline: Diagnosis | None = None,
) -> tuple[Diagnosis, Evidence]:
    """Return the diagnosis of a recording, judged by its reference, and what shows it; nothing is written."""
    if baseline is not None:
        check_usable(baseline, Path(baseline.recording))
        check_same_sensors(baseline, recording)
    diagnosis, evidence = diagnose(recording, step, budget, tolerance, baseline)
    diagnosis = with_shares(diagnosis, evidence)
    return (with_reference_errors(diagnosis, evidence, reference) if diagnosis.fitted else diagnosis), evidence


def _told(
    baseline: Path, recording: Recording, target: Path, step: Step, time_limit: float, tolerance: Pair
) -> Diagnosis:
    """Return the diagnosis in a folder, or that of the recording in it, which is written into `target`."""
    if baseline.is_file() or (baseline / FILE_NAME).is_file():
        told = read_diagnosis(baseline)
    else:
        with step(f"read {baseline}"):
            earlier, reference = read(baseline)
        check_same_sensors(earlier, recording)
        target.mkdir()
        told = _written(earlier, reference, target, step, Budget(time_limit), tolerance).diagnosis
    check_usable(told, baseline)
    check_same_sensors(told, recording)
    return told


def _written(
    recording: Recording,
    reference: Reference | None,
    target: Path,
    step: Step,
    budget: Budget,
    tolerance: Pair,
    baseline: Diagnosis | None = None,
    paths: Paths | None = None,
) -> Done:
    """Return the diagnosis of a recording, after writing it into the empty folder `target`."""
    diagnosis, evidence = diagnosed(recording, reference, step, budget, tolerance, baseline)
    with step("estimate with and without what was found"):
        evidence = with_estimates(diagnosis, evidence, recording, reference, budget)
    with step("write the model"):
        (target / MODEL).mkdir()
        name = write_model(diagnosis, evidence, target / MODEL)
        diagnosis = replace(diagnosis, model=f"{MODEL}/{name}")
    write_json(target / FILE_NAME, as_dict(diagnosis) | estimates_as_dict(evidence.estimates))
    with step("write the Rerun file"):
        log_diagnosis(target / LOG, diagnosis, evidence, reference)
    with step("draw the report"):
        (target / REPORT).write_text(page(diagnosis, evidence, paths), encoding="utf-8")
    return Done(diagnosis, evidence)


def with_estimates(
    diagnosis: Diagnosis, evidence: Evidence, recording: Recording, reference: Reference | None, budget: Budget
) -> Evidence:
    """Return the evidence with what the project's estimators make of a recording with and without the findings.

    Without them, and the notes say why, where the findings cannot be taken out, or the time limit came first.
    """
    found: tuple[Estimated, ...] = ()
    why = f"the {budget.limit:g} s of processor time were spent"
    with budget.rest("what estimators make of it"):
        try:
            found = estimates(recording, diagnosis, reference) if diagnosis.fitted else ()
            why = ""
        except InputError as error:
            why = str(error)
    note = f"No estimator was asked with and without the findings: {why}."
    return replace(evidence, estimates=found, notes=(*evidence.notes, note) if why else evidence.notes)


def estimates_as_dict(found: tuple[Estimated, ...]) -> dict[str, Any]:
    """Return `estimates` of diagnosis.json; nothing where there are none."""

    def one(e: Estimated) -> dict[str, Any]:
        out: dict[str, Any] = {
            "estimator": e.estimator,
            "quantity": e.quantity,
            "unit": e.unit,
            "moved": e.moved.tolist(),
            "by_finding": [None if by is None else by.tolist() for by in e.each],
            "status": {"as_it_came": e.status[0], "without": e.status[1]},
        }
        if e.off is not None:
            out["reference"] = {"as_it_came": e.off[0].tolist(), "without": e.off[1].tolist()}
        return out

    return {"estimates": [one(e) for e in found]} if found else {}
