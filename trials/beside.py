"""What is held beside the diagnosis on the same cases: baselines, and itself without the effect in its library."""

from collections.abc import Mapping, Sequence
from concurrent.futures import as_completed
from pathlib import Path

from imubench import format1
from imubench.answers import write_json
from imubench.atomic import atomic_file
from imubench.diagnosis.candidates.begin import begin
from imubench.diagnosis.result import Diagnosis
from imubench.diagnosis.result_file import as_dict
from imubench.diagnosis.result_read import read_diagnosis
from imubench.effects import EFFECTS
from imubench.errors import InputError
from imubench.inputs.json import load_json
from imubench.progress import Report
from imubench.trials import baselines
from imubench.trials.oracle import oracle
from imubench.trials.scoring import CaseScore, failed, score
from imubench.trials.seal import Truth
from imubench.workers import process_pool

FITTED = ("L1", "oracle")


def fitted(recording: Path, truth: Truth, kept: Path) -> None:
    """Put what L1 and the oracle say of a case into `kept`, or why they say nothing."""
    try:
        start = begin(format1.read(recording)[0])
        said: Mapping[str, Diagnosis] = {"L1": baselines.l1(start.first), "oracle": oracle(start, truth)}
    except Exception as error:  # a baseline that breaks is counted, it does not stop the trials
        with atomic_file(kept / "error.json") as partial:
            write_json(partial, f"{type(error).__name__}: {error}")
        return
    for name in FITTED:
        with atomic_file(kept / f"{name}.json") as partial:
            write_json(partial, as_dict(said[name]))


def fit_baselines(
    truths: Mapping[str, Truth], cases: Path, folder: Path, workers: int, report: Report
) -> dict[str, tuple[CaseScore, ...]]:
    """Return the scores of L1 and the oracle, fitted where an earlier run has not."""
    open_ones = [n for n in truths if not list((folder / n).glob("*.json"))]
    done = len(truths) - len(open_ones)
    report("fit baselines", done, len(truths))
    if open_ones:
        with process_pool(workers) as pool:
            pending = [pool.submit(fitted, cases / n / "recording", truths[n], folder / n) for n in open_ones]
            for future in as_completed(pending):
                future.result()
                done += 1
                report("fit baselines", done, len(truths))
    return {b: tuple(_scored(n, truths[n], folder / n, b) for n in truths) for b in FITTED}


def _scored(name: str, truth: Truth, folder: Path, baseline: str) -> CaseScore:
    error = folder / "error.json"
    if error.is_file():
        return failed(name, truth, 0.0, str(load_json(error)))
    return score(name, truth, read_diagnosis(folder / f"{baseline}.json"), 0.0, float("inf"))


def residual_size(
    truths: Mapping[str, Truth], scores: Sequence[CaseScore], answers: Path, alarm: float
) -> tuple[CaseScore, ...]:
    """Return the scores of the misfit's size alone, as the diagnoses state it."""
    out = []
    for s in scores:
        truth = truths[s.name]
        try:
            said = baselines.residual_size(read_diagnosis(answers / s.name), alarm)
            out.append(score(s.name, truth, said, 0.0, alarm))
        except InputError as error:
            out.append(failed(s.name, truth, 0.0, str(error)))
    return tuple(out)


def to_leave_out(truths: Mapping[str, Truth], scores: Sequence[CaseScore]) -> dict[str, str]:
    """Return, for each case of a lone effect that was found, the effect to take out of the library.

    Not where the table has a twin of it, which stays and is right; nor where the raw samples tell it, a fault or a hum:
    that is not in what `guard` takes out.
    """
    out = {}
    for s in scores:
        truth = truths[s.name]
        if s.kind == "one" and s.observable and s.alarm and len(truth["answers"][0]) == 1:
            effect = EFFECTS.get(truth["effects"][0]["effect"])
            if effect is not None and (effect.parameters or effect.states) and not effect.tone:
                out[s.name] = effect.name
    return out


def without(truth: Truth) -> Truth:
    """Return a truth of a lone effect as it stands for a library that does not have it."""
    return truth | {"kind": "outside", "effects": [truth["effects"][0] | {"inside": False}]}
