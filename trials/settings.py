"""What a proof is about: its settings, the questions that follow from them, and a key that both and the code share."""

import hashlib
import json
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np

import imubench
from imubench.proof.mixture import Question, mixture
from imubench.reproduce.parts import hash_code
from imubench.trials import blind
from imubench.trials.crime import Simulated, simulable, twice
from imubench.trials.make import shortened
from imubench.trials.real import Added, questions

CODE = (
    "imubench", "imubench.diagnosis", "imubench.effects", "imubench.estimators", "imubench.models", "imubench.proof",
    "imubench.sim", "imubench.trials",
)  # fmt: skip


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


def asked_of(settings: Settings) -> dict[str, Question | Added | Simulated]:
    """Return what the settings ask for, by the names of the cases."""
    if settings.added:
        return dict(questions(Path(settings.added), settings.seed, settings.cases))
    mixed = mixture(settings.seed, settings.cases)
    asked: dict[str, Question] = {f"{i:03d}": shortened(question, settings.seconds) for i, question in enumerate(mixed)}
    return {**asked, **(twice(asked) if settings.crime else {})}


def not_simulated(settings: Settings) -> dict[str, str]:
    """Return the cases that the project's own simulator cannot play, each with the reason."""
    if not settings.crime:
        return {}
    return {n: why for n, q in asked_of(settings).items() if isinstance(q, Question) and (why := simulable(q))}


def key(settings: Settings) -> str:
    """Return a name that changes with what an answer depends on: the settings less what comes beside, and the code."""
    asked = replace(settings, baselines=False, leave_one_out=False)  # so that these may be added, or given up, later
    digest = hashlib.sha256(json.dumps([imubench.__version__, np.__version__, asdict(asked)]).encode())
    hash_code(digest, CODE)
    return digest.hexdigest()[:16]


__all__ = ["Settings", "asked_of", "key", "not_simulated"]
