"""Estimators: from a `Recording`, and nothing else, to an `Estimate`. One file a method, one line here."""

from collections.abc import Callable
from dataclasses import dataclass

from imubench.errors import unknown
from imubench.estimate import Estimate, Quantity
from imubench.estimators import olsson2020, seel2012
from imubench.recording import Recording


@dataclass(frozen=True)
class Estimator:
    """A method by its name, what it answers, and what it needs."""

    name: str
    summary: str  # one line
    quantity: Quantity
    imus: int  # how many it needs
    estimate: Callable[[Recording], Estimate]
    source: str


ESTIMATORS: dict[str, Estimator] = {
    e.name: e
    for e in (
        Estimator(
            "olsson2020",
            "hinge axis from gyroscopes and accelerometers, both sign pairings tried",
            "joint_axis",
            2,
            olsson2020.estimate,
            "Olsson, Kok, Seel, Halvorsen, Sensors 20 (2020) 3534, Algorithm 1",
        ),
        Estimator(
            "seel2012",
            "hinge axis from gyroscopes alone; the sign pairing is taken from the declared mounts",
            "joint_axis",
            2,
            seel2012.estimate,
            "Seel, Schauer, Raisch, IEEE International Conference on Control Applications (2012) 45-49",
        ),
    )
}


def find(name: str) -> Estimator:
    """Return the estimator of that name; `InputError` lists the known ones."""
    if name not in ESTIMATORS:
        raise unknown("estimator", name, ESTIMATORS)
    return ESTIMATORS[name]
