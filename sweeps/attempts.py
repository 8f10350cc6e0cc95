"""Attempts of estimators at recordings: each worker has one process apart, in which they run one after the other."""

import re

from imubench.attempt import Failed, attempted, own_apart
from imubench.estimate import Estimate
from imubench.estimators import Estimator
from imubench.recording import Recording

ADDRESS = re.compile(r"0x[0-9a-fA-F]{6,}")  # of an object in memory, another one in every run


def attempt(estimator: Estimator, recording: Recording, seconds: float) -> Estimate | Failed:
    """Return an estimate, or how it failed; one that takes longer than `seconds` s by the clock is stopped."""
    return attempted(estimator, recording, seconds, own_apart())


def end() -> None:
    """End the process apart, where this process has one."""
    own_apart().end()


def why(failed: Failed) -> str:
    """Return why there is no estimate, in words that are the same in every run."""
    return ADDRESS.sub("0x...", failed.why)
