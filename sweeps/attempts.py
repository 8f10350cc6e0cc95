"""One attempt of an estimator at a recording, in a process of its own."""

from imubench.estimate import Estimate
from imubench.estimators import Estimator
from imubench.recording import Recording


def attempt(estimator: Estimator, recording: Recording, seconds: float) -> Estimate | str:
    """Return an estimate, or `how it failed: why`."""
    try:
        return estimator.estimate(recording)
    except Exception as error:
        return f"crashed: {error!r}"
