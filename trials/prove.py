"""Blind trials from a seed to a folder with everything: cases made, truths sealed, diagnosed, opened, scored."""

import platform
import shutil
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

import imubench
from imubench.answers import write_json
from imubench.atomic import atomic_directory
from imubench.inputs.files import real
from imubench.inputs.json import load_table
from imubench.inputs.limits import JSON_BYTES
from imubench.progress import Report
from imubench.trials import blind
from imubench.trials.beside import fit_baselines, residual_size, to_leave_out, without
from imubench.trials.crime import SUFFIX, compared
from imubench.trials.detection import by_strength
from imubench.trials.figures import Figure, figures, reliability
from imubench.trials.judge import ALARM, in_pairs, one_by_one, scored, with_replays
from imubench.trials.scoring import CaseScore
from imubench.trials.seal import Truth, check, salt_of
from imubench.trials.sealed import as_scored, opened, publish_sealed
from imubench.trials.settings import Settings, asked_of, key, not_simulated
from imubench.trials.stages import diagnose_cases, make_cases, publish
from imubench.workers import cores

LEFT_OUT = ("answered", "confidently_wrong", "outside_flagged", "outside_located")
"""What is asked where the effect is not in the library."""


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
        """Whether no guard is broken and nobody cheated."""
        return not self.refused and not any(f.passed for f in self.figures)


def prove(settings: Settings, out: Path, workers: int, report: Report, announce: Callable[[str], None]) -> Proof:
    """Do the trials and write commitments.json, truths.json, proof.json, report.html and diagnoses/ into `out`.

    `announce` gets the SHA-256 of commitments.json before the first diagnosis starts. Finished diagnoses are kept in a
    hidden folder beside `out` until the end, so that the same settings go on after a kill.
    """
    home = real(out).parent / f".{real(out).name}.trials"
    kept = home / key(settings)
    inputs = [Path(given) for given in (settings.added, settings.real) if given]
    with atomic_directory(out, inputs) as target:
        proof = _proved(settings, kept, target, workers, report, announce)
    shutil.rmtree(kept, ignore_errors=True)
    with suppress(OSError):  # a run with other settings is not finished
        home.rmdir()
    return proof


def _proved(
    settings: Settings, kept: Path, target: Path, workers: int, report: Report, announce: Callable[[str], None]
) -> Proof:
    from imubench.trials.report import page

    truths: dict[str, Truth] = {}
    if settings.real:
        names, sealed = publish_sealed(Path(settings.real), kept, settings.seconds)
    else:
        truths = make_cases(asked_of(settings), kept / "cases", workers, report)
        names, sealed = list(truths), publish(truths, kept, settings.seed)
    announce(sealed)
    runs = diagnose_cases(dict.fromkeys(names, "-"), "answers", kept, settings, workers, report)
    commitments = load_table(kept / "commitments.json", JSON_BYTES)["cases"]
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
    if not settings.added:
        scores = with_replays(scores, truths, kept / "answers", kept / "cases", workers, report)
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
        not_simulated(settings),
    )  # fmt: skip
    text = page(proof)
    shutil.copyfile(kept / "commitments.json", target / "commitments.json")
    write_json(target / "truths.json", {n: {"salt": salts[n], "truth": told[n]} for n in names})
    write_json(target / "proof.json", as_dict(proof))
    (target / "diagnoses").mkdir()
    for name in names:
        answer = kept / "answers" / name / "diagnosis.json"
        if answer.is_file():
            shutil.copyfile(answer, target / "diagnoses" / f"{name}.json")
    (target / "report.html").write_text(text, encoding="utf-8")
    return proof


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
