"""Blind trials from a seed to a folder with everything: cases made, truths sealed, diagnosed, opened, scored."""

import hashlib
import json
import multiprocessing
import platform
import shutil
from collections.abc import Callable, Mapping
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, ThreadPoolExecutor, as_completed, wait
from dataclasses import asdict, dataclass, field, replace
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

import imubench
from imubench.answers import write_json
from imubench.atomic import atomic_directory, atomic_file
from imubench.errors import InputError
from imubench.proof.mixture import Question, mixture
from imubench.reproduce.parts import cores, ignore_interrupts, one_thread_each, sources
from imubench.trials import blind
from imubench.trials.beside import fit_baselines, residual_size, to_leave_out, without
from imubench.trials.crime import SUFFIX, Simulated, compared, made_simulated, simulable, twice
from imubench.trials.figures import Figure, by_strength, figures, reliability
from imubench.trials.judge import ALARM, in_pairs, one_by_one, scored
from imubench.trials.make import made, refuse_leaks, shortened
from imubench.trials.real import Added, made_real, questions
from imubench.trials.scoring import CaseScore
from imubench.trials.seal import Truth, check, commitment, folder_hash, salt_of
from imubench.trials.sealed import as_scored, opened, publish_sealed

CODE = (
    "imubench", "imubench.diagnosis", "imubench.effects", "imubench.estimators", "imubench.models", "imubench.proof",
    "imubench.sim", "imubench.trials",
)  # fmt: skip
LEFT_OUT = ("answered", "confidently_wrong", "outside_flagged", "outside_located")
"""What is asked where the effect is not in the library."""

Report = Callable[[str, int, int], None]
"""Takes the stage, how many of it are done, and how many there are."""


@dataclass(frozen=True)
class Settings:
    """What a proof is about."""

    cases: int
    seed: int
    command: str = blind.OURS
    timeout: float = 300.0  # s for a diagnosis
    seconds: float | None = None  # recordings are at most that long
    baselines: bool = False  # L1 and the oracle on the same cases
    added: str = ""  # a folder of real recordings to add effects to, instead of the generator's
    real: str = ""  # a folder of recordings with sealed sidecars, instead of the generator's
    crime: bool = False  # the same questions again, played by the project's own `sim`
    leave_one_out: bool = False  # again, with the effect that was found taken out of the library


@dataclass(frozen=True)
class Proof:
    """Everything that came out."""

    settings: Settings
    scores: tuple[CaseScore, ...]
    figures: tuple[Figure, ...]
    refused: dict[str, tuple[str, ...]]  # case -> what its diagnosis tried and has no business with
    sealed: str  # SHA-256 of commitments.json
    how: dict[str, Any]
    beside: dict[str, tuple[CaseScore, ...]]  # baseline -> its scores
    left_out: tuple[CaseScore, ...] = ()  # of the diagnosis without the effect in its library
    simulated: tuple[CaseScore, ...] = ()  # of the same questions played by `sim`
    not_simulated: dict[str, str] = field(default_factory=dict)  # case -> why `sim` cannot

    @property
    def fit_for_the_build(self) -> bool:
        """Whether no guard is passed and nobody cheated."""
        return not self.refused and not any(f.passed for f in self.figures)


def prove(settings: Settings, out: Path, workers: int, report: Report, announce: Callable[[str], None]) -> Proof:
    """Do the trials and write commitments.json, truths.json, proof.json, report.html and diagnoses/ into `out`.

    `announce` gets the SHA-256 of commitments.json before the first diagnosis starts. Finished diagnoses are kept in a
    hidden folder beside `out` until the end, so that the same settings go on after a kill.
    """
    from imubench.trials.report import page

    home = out.resolve().parent / f".{out.resolve().name}.trials"
    kept = home / _key(settings)
    if home.is_dir():
        for older in home.iterdir():
            if older != kept:
                shutil.rmtree(older)
    truths: dict[str, Truth] = {}
    if settings.real:
        names, sealed = publish_sealed(Path(settings.real), kept, settings.seconds)
    else:
        truths = make_cases(asked_of(settings), kept / "cases", workers, report)
        names, sealed = list(truths), publish(truths, kept, settings.seed)
    announce(sealed)
    runs = diagnose_cases(dict.fromkeys(names, "-"), "answers", kept, settings, workers, report)
    commitments = json.loads((kept / "commitments.json").read_text(encoding="utf-8"))["cases"]
    salts = {name: salt_of(settings.seed, name) for name in names}
    if settings.real:
        truths, salts = opened(Path(settings.real), names)
    check(commitments, truths, salts)
    told = truths
    if settings.real:
        truths = {n: as_scored(truths[n], kept / "cases" / n / "recording") for n in names}
    judge = in_pairs if settings.added else one_by_one
    scores = judge(truths, kept / "answers", runs)
    simulated = tuple(s for s in scores if s.name.endswith(SUFFIX))
    scores = tuple(s for s in scores if s not in simulated)
    truths = {s.name: truths[s.name] for s in scores}
    refused = {name: run.refused for name, run in runs.items() if run.refused}
    others = {} if settings.added else {"residual size": residual_size(truths, scores, kept / "answers", ALARM)}
    if settings.baselines and not settings.added:
        others |= fit_baselines(truths, kept / "cases", kept / "baselines", workers, report)
    left_out: tuple[CaseScore, ...] = ()
    if settings.leave_one_out and not settings.added:
        asked = to_leave_out(truths, scores)
        again = diagnose_cases(asked, "left_out", kept, settings, workers, report)
        left_out = tuple(scored(n, without(truths[n]), kept / "left_out" / n, again[n]) for n in asked)
    proof = Proof(
        settings, scores, tuple(figures(scores)), refused, sealed, _how(workers), others, left_out, simulated,
        _not_simulated(settings),
    )  # fmt: skip
    text = page(proof)
    with atomic_directory(out) as target:
        shutil.copyfile(kept / "commitments.json", target / "commitments.json")
        write_json(target / "truths.json", {n: {"salt": salts[n], "truth": told[n]} for n in names})
        write_json(target / "proof.json", as_dict(proof))
        (target / "diagnoses").mkdir()
        for name in names:
            answer = kept / "answers" / name / "diagnosis.json"
            if answer.is_file():
                shutil.copyfile(answer, target / "diagnoses" / f"{name}.json")
        (target / "report.html").write_text(text, encoding="utf-8")
    shutil.rmtree(home, ignore_errors=True)
    return proof


def asked_of(settings: Settings) -> dict[str, Question | Added | Simulated]:
    """Return what the settings ask for, by the names of the cases."""
    if settings.added:
        return dict(questions(Path(settings.added), settings.seed, settings.cases))
    mixed = mixture(settings.seed, settings.cases)
    asked: dict[str, Question] = {f"{i:03d}": shortened(question, settings.seconds) for i, question in enumerate(mixed)}
    return {**asked, **(twice(asked) if settings.crime else {})}


def _not_simulated(settings: Settings) -> dict[str, str]:
    if not settings.crime:
        return {}
    return {n: why for n, q in asked_of(settings).items() if isinstance(q, Question) and (why := simulable(q))}


def make_cases(
    asked: Mapping[str, Question | Added | Simulated], folder: Path, workers: int, report: Report
) -> dict[str, Truth]:
    """Make every recording anew under `folder`, and return the truths, which stay in memory."""
    shutil.rmtree(folder, ignore_errors=True)
    truths: dict[str, Truth] = {}
    report("make recordings", 0, len(asked))
    context = multiprocessing.get_context("spawn")
    with one_thread_each(), ProcessPoolExecutor(workers, mp_context=context, initializer=ignore_interrupts) as pool:
        pending = {
            pool.submit(any_made, question, folder / name / "recording"): name for name, question in asked.items()
        }
        try:
            for future in as_completed(pending):
                name = pending[future]
                truths[name] = future.result()
                refuse_leaks(folder / name / "recording", truths[name])
                report("make recordings", len(truths), len(asked))
        except BaseException:
            pool.shutdown(wait=True, cancel_futures=True)
            raise
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
        if json.loads(file.read_text(encoding="utf-8")) != content:
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
    children = blind.Children()
    with ThreadPoolExecutor(workers) as pool:
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
        try:
            while pending:
                for future in wait(pending, return_when=FIRST_COMPLETED)[0]:
                    runs[pending.pop(future)] = future.result()
                    report(stage, len(runs), len(names))
        except BaseException:
            children.stop()
            pool.shutdown(wait=True, cancel_futures=True)
            raise
    return {name: runs[name] for name in names}


def any_made(question: Question | Added | Simulated, folder: Path) -> Truth:
    """Write the recording of a question of any kind, and return its truth."""
    if isinstance(question, Added):
        return made_real(question, folder)
    return made_simulated(question, folder) if isinstance(question, Simulated) else made(question, folder)


def as_dict(proof: Proof) -> dict[str, Any]:
    """Return the content of proof.json."""
    return {
        "format": 1,
        "settings": asdict(proof.settings),
        "how": proof.how,
        "commitments_sha256": proof.sealed,
        "figures": [asdict(f) for f in proof.figures],
        "detection": [asdict(row) | {"high": min(row.high, 1e9)} for row in by_strength(proof.scores)],
        "reliability": reliability(proof.scores),
        "beside": {b: [asdict(f) for f in figures(scores)] for b, scores in proof.beside.items()},
        "left_out": {
            "figures": [asdict(f) for f in figures(proof.left_out) if f.name in LEFT_OUT],
            "cases": [asdict(s) for s in proof.left_out],
        },
        "crime": {
            "figures": compared(proof.scores, proof.simulated) if proof.simulated else [],
            "cases": [asdict(s) for s in proof.simulated],
            "not_simulated": proof.not_simulated,
        },
        "refused": {name: list(what) for name, what in proof.refused.items()},
        "cases": [asdict(s) for s in proof.scores],
    }


def _key(settings: Settings) -> str:
    """Return a name that changes with what an answer depends on: the settings less what comes beside, and the code."""
    asked = replace(settings, baselines=False, leave_one_out=False)  # so that these may be added, or given up, later
    digest = hashlib.sha256(json.dumps([imubench.__version__, np.__version__, asdict(asked)]).encode())
    for package in CODE:
        for name, content in sorted(sources(files(package))):
            digest.update(f"{package}/{name}".encode() + content)
    return digest.hexdigest()[:16]


def _how(workers: int) -> dict[str, Any]:
    return {
        "imubench": imubench.__version__,
        "python": platform.python_version(),
        "numpy": np.__version__,
        "system": platform.system(),
        "workers": workers,
        "cores": cores(),
        "separation": blind.PROTOCOL,
        "namespaces": bool(blind.namespaces()),
    }
