"""The stages of a proof: recordings made, their truths sealed, each diagnosed."""

import hashlib
import shutil
from collections.abc import Mapping
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, as_completed, wait
from pathlib import Path

from imubench.answers import write_json
from imubench.atomic import atomic_file
from imubench.errors import InputError
from imubench.inputs.json import load_json
from imubench.inputs.limits import JSON_BYTES
from imubench.leftovers import undone
from imubench.progress import Report
from imubench.proof.mixture import Question
from imubench.trials import blind
from imubench.trials.crime import Simulated, made_simulated
from imubench.trials.make import made, refuse_leaks
from imubench.trials.real import Added, made_real
from imubench.trials.seal import Truth, commitment, folder_hash, salt_of
from imubench.trials.settings import Settings
from imubench.workers import process_pool


def make_cases(
    asked: Mapping[str, Question | Added | Simulated], folder: Path, workers: int, report: Report
) -> dict[str, Truth]:
    """Make every recording anew under `folder`, and return the truths, which stay in memory."""
    shutil.rmtree(folder, ignore_errors=True)
    truths: dict[str, Truth] = {}
    report("make recordings", 0, len(asked))
    with process_pool(workers) as pool:
        pending = {
            pool.submit(any_made, question, folder / name / "recording"): name for name, question in asked.items()
        }
        for future in as_completed(pending):
            name = pending[future]
            truths[name] = future.result()
            refuse_leaks(folder / name / "recording", truths[name])
            report("make recordings", len(truths), len(asked))
    return {name: truths[name] for name in asked}


def publish(truths: dict[str, Truth], kept: Path, seed: int) -> str:
    """Write commitments.json, flushed to the disk, and return its SHA-256.

    Where an earlier run has published it, the truths must be those; `InputError` otherwise.
    """
    content = {
        "format": 1,
        "hash": "SHA-256 of the truth (JSON, sorted keys, no spaces) followed by the salt",
        "cases": {
            name: {
                "truth": commitment(truth, salt_of(seed, name)),
                "recording": folder_hash(kept / "cases" / name / "recording"),
            }
            for name, truth in truths.items()
        },
    }
    file = kept / "commitments.json"
    if file.is_file():
        if load_json(file, JSON_BYTES) != content:
            raise InputError(f"{file}: expected the cases that an earlier run sealed, got others; remove {kept}")
    else:
        with atomic_file(file) as partial:
            write_json(partial, content)
    return hashlib.sha256(file.read_bytes()).hexdigest()


def diagnose_cases(
    names: dict[str, str], folder: str, kept: Path, settings: Settings, workers: int, report: Report
) -> dict[str, blind.Run]:
    """Diagnose every case that an earlier run did not finish, into `folder`.

    names: case -> effect taken out of the library, - for none.
    """
    earlier = {name: blind.finished(kept / folder / name) for name in names}
    runs = {name: run for name, run in earlier.items() if run is not None}
    stage = "diagnose" if folder == "answers" else "leave one out"
    report(stage, len(runs), len(names))
    for name in names:
        blind.remove_rooms(kept / folder / name)
        break  # one for all: they are named by the folder
    children, pool = blind.Children(), ThreadPoolExecutor(workers)

    def end() -> None:
        children.stop()
        pool.shutdown(wait=True, cancel_futures=True)

    with undone(end):
        pending: dict[Future[blind.Run], str] = {
            pool.submit(
                blind.diagnosed,
                kept / "cases" / name / "recording",
                kept / folder / name,
                settings.command,
                settings.timeout,
                children,
                left_out,
            ): name
            for name, left_out in names.items()
            if name not in runs
        }
        while pending:
            for future in wait(pending, return_when=FIRST_COMPLETED)[0]:
                runs[pending.pop(future)] = future.result()
                report(stage, len(runs), len(names))
    return {name: runs[name] for name in names}


def any_made(question: Question | Added | Simulated, folder: Path) -> Truth:
    """Write the recording of a question of any kind, and return its truth."""
    if isinstance(question, Added):
        return made_real(question, folder)
    return made_simulated(question, folder) if isinstance(question, Simulated) else made(question, folder)


__all__ = ["Report", "any_made", "diagnose_cases", "make_cases", "publish"]
