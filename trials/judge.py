"""The answers of a proof against its opened truths: one by one, in pairs, or as their experimenters documented."""

from collections.abc import Mapping, Sequence
from concurrent.futures import as_completed
from dataclasses import replace
from pathlib import Path

from imubench.diagnosis.result_read import read_diagnosis
from imubench.errors import InputError
from imubench.progress import Report
from imubench.trials import blind
from imubench.trials.real import beside
from imubench.trials.replayed import Replayed, replayed
from imubench.trials.scoring import CaseScore, failed, score
from imubench.trials.seal import Truth
from imubench.trials.sealed import without_known
from imubench.workers import process_pool

ALARM = 1.15**2 * 1.2
"""The misfit from which its size alone is an alarm: a declared noise right within 15 %, 20 % of coloured noise."""


def one_by_one(truths: Mapping[str, Truth], answers: Path, runs: Mapping[str, blind.Run]) -> tuple[CaseScore, ...]:
    """Return the score of every case."""
    return tuple(scored(name, truth, answers / name, runs[name]) for name, truth in truths.items())


def with_replays(
    scores: Sequence[CaseScore],
    truths: Mapping[str, Truth],
    answers: Path,
    cases: Path,
    workers: int,
    report: Report,
) -> tuple[CaseScore, ...]:
    """Return the scores with what the simulations of each diagnosis were worth; `cases` holds the recordings."""
    asked = [s.name for s in scores if s.alarm and s.observable and s.truth]
    report("replay models", 0, len(asked))
    found: dict[str, Replayed] = {}
    if asked:
        with process_pool(workers) as pool:
            pending = {
                pool.submit(_replayed, truths[name], answers / name, cases / name / "recording"): name for name in asked
            }
            for future in as_completed(pending):
                found[pending[future]] = future.result()
                report("replay models", len(found), len(asked))
    return tuple(replace(s, replayed=found.get(s.name, s.replayed)) for s in scores)


def _replayed(truth: Truth, answer: Path, recording: Path) -> Replayed:
    return replayed(truth, read_diagnosis(answer), answer, recording)


def in_pairs(truths: Mapping[str, Truth], answers: Path, runs: Mapping[str, blind.Run]) -> tuple[CaseScore, ...]:
    """Return the score of every case with an effect, beside the diagnosis of the untouched recording."""
    out = []
    for name, truth in truths.items():
        if truth["effects"]:
            plain_one, run = scored(name, truth, answers / name, runs[name]), runs[name]
            untouched = scored(truth["base"], truths[truth["base"]], answers / truth["base"], runs[truth["base"]])
            if untouched.failed or plain_one.failed:
                out.append(replace(plain_one, failed=plain_one.failed or f"untouched: {untouched.failed}"))
            else:
                new = beside(read_diagnosis(answers / name), read_diagnosis(answers / truth["base"]))
                out.append(score(name, truth, new, run.seconds, ALARM))
    return tuple(out)


def scored(name: str, truth: Truth, answer: Path, run: blind.Run) -> CaseScore:
    """Return the score of one case; a diagnosis that broke off, cheated or broke the interface has none."""
    if run.refused:
        return failed(name, truth, run.seconds, f"tried to see more than its recording: {run.refused[0]}")
    if run.code != 0:
        return failed(name, truth, run.seconds, run.error)
    try:
        said = read_diagnosis(answer)
    except InputError as error:
        return failed(name, truth, run.seconds, str(error).replace(str(answer), "diagnosis.json"))
    return score(name, truth, without_known(said, truth) if "may" in truth else said, run.seconds, ALARM)
