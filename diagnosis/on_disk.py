"""A recording on disk to a folder with everything about its diagnosis."""

from dataclasses import dataclass, replace
from pathlib import Path

from imubench.answers import write_json
from imubench.atomic import atomic_directory
from imubench.diagnosis.budget import DEFAULT, Budget
from imubench.diagnosis.diagnose import diagnose
from imubench.diagnosis.evidence import Evidence
from imubench.diagnosis.export import write_model
from imubench.diagnosis.judge import judged
from imubench.diagnosis.report import page
from imubench.diagnosis.rerun_log import log_diagnosis
from imubench.diagnosis.result import TOLERANCE, Diagnosis, Pair
from imubench.diagnosis.result_file import FILE_NAME, as_dict
from imubench.errors import InputError
from imubench.format1 import read
from imubench.progress import Step, silent

REPORT, LOG, MODEL = "report.html", "diagnosis.rrd", "model"


@dataclass(frozen=True)
class Done:
    """A diagnosis, what shows it, and what could not be written."""

    diagnosis: Diagnosis
    evidence: Evidence
    missing: str = ""  # why there is no report


def diagnose_on_disk(
    folder: Path, out: Path, step: Step = silent, time_limit: float = DEFAULT, tolerance: Pair = TOLERANCE
) -> Done:
    """Diagnose a recording in format 1 and write diagnosis.json, report.html, diagnosis.rrd and model/ into `out`.

    The reference, if there is one, only judges. Without matplotlib everything but the report is written. After
    `time_limit` s of processor time what is known by then is written. A finding that moves nothing by `tolerance` (deg,
    mm) is not material.
    """
    budget = Budget(time_limit)
    missing = ""
    with atomic_directory(out, [Path(folder)]) as target:
        with step(f"read {folder}"):
            recording, reference = read(folder)
        diagnosis, evidence = diagnose(recording, step, budget, tolerance)
        diagnosis = judged(diagnosis, evidence, reference) if diagnosis.fitted else diagnosis
        with step("write the model"):
            (target / MODEL).mkdir()
            name = write_model(diagnosis, evidence, target / MODEL)
            diagnosis = replace(diagnosis, model=f"{MODEL}/{name}")
        write_json(target / FILE_NAME, as_dict(diagnosis))
        with step("write the Rerun file"):
            log_diagnosis(target / LOG, diagnosis, evidence, reference)
        with step("draw the report"):
            try:
                (target / REPORT).write_text(page(diagnosis, evidence), encoding="utf-8")
            except InputError as error:
                missing = str(error)
    return Done(diagnosis, evidence, missing)
