"""What an estimator answers."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from imubench.arrays import Array, frozen
from imubench.callable_module import call_as
from imubench.displays import Displayed
from imubench.errors import InputError, unknown

Quantity = Literal["joint_axis", "joint_vector"]
QUANTITIES: tuple[Quantity, ...] = ("joint_axis", "joint_vector")
Status = Literal["converged", "not converged", "not identifiable"]
STATUSES: tuple[Status, ...] = ("converged", "not converged", "not identifiable")
Pairing = Literal["from data", "from declared mounts", "unknown"]
"""What says how the signs of two axes go together; `unknown`: nothing does, and (j1, -j2) is as good an answer."""
PAIRINGS: tuple[Pairing, ...] = ("from data", "from declared mounts", "unknown")

Failure = Literal["crashed", "timed out", "malformed", "refused"]


class AnswerError(InputError):
    """An estimator's answer is no estimate: a wrong shape, NaN, an axis that is no unit vector, ..."""


@dataclass(frozen=True)
class Estimate(Displayed):
    """A value with its covariance, or the reason why there is none.

    `joint_axis`: value (m, 3), one unit vector per IMU in its sensor axes, their signs paired as `pairing` says. An
    estimator that leaves it out claims its signs, and is judged by them.
    `joint_vector`: value (m, 3) in m, one r per IMU; with `time`, value (n, m, 3), one per sample.
    `covariance` is (3m, 3m), or (n, 3m, 3m), of the stacked value.

    Raises `AnswerError` for a shape, a name or a number that none of these can have.
    """

    quantity: Quantity
    estimator: str
    value: Array
    covariance: Array | None
    no_covariance_because: str = ""
    status: Status = "converged"
    time: Array | None = None  # (n,) s, for one value a sample
    details: Mapping[str, float] = field(default_factory=dict)  # cost, iterations, ...
    pairing: Pairing | None = None  # None: not said, or not an axis

    def __post_init__(self) -> None:
        try:
            self._check()
        except InputError as error:
            raise AnswerError(error) from None

    def _check(self) -> None:
        for kind, name, known in (("quantity", self.quantity, QUANTITIES), ("status", self.status, STATUSES)):
            if name not in known:
                raise unknown(f"{kind} of {self.estimator}", name, known)
        if self.time is not None:
            object.__setattr__(self, "time", frozen(self.time, (None,), f"{self.estimator}.time"))
        n = () if self.time is None else (len(self.time),)
        value = frozen(self.value, (*n, None, 3), f"{self.estimator}.value")
        object.__setattr__(self, "value", value)
        if self.quantity == "joint_axis" and not np.allclose(np.linalg.norm(value, axis=-1), 1.0, atol=1e-6):
            raise InputError(f"{self.estimator}.value: expected unit vectors, got {value.tolist()}")
        if self.pairing is not None and self.pairing not in PAIRINGS:
            raise unknown(f"pairing of {self.estimator}", self.pairing, PAIRINGS)
        if self.pairing is not None and self.quantity != "joint_axis":
            raise InputError(f"{self.estimator}.pairing: expected none for a {self.quantity}, got '{self.pairing}'")
        if self.covariance is None:
            if not self.no_covariance_because:
                raise InputError(f"{self.estimator}: expected a covariance or a reason why there is none, got neither")
        else:
            width = 3 * value.shape[-2]
            covariance = frozen(self.covariance, (*n, width, width), f"{self.estimator}.covariance")
            object.__setattr__(self, "covariance", covariance)


@dataclass(frozen=True)
class Failed:
    """Why there is no estimate.

    `crashed`: it raised an error, or its process died. `timed out`: it took longer than it was given. `malformed`: it
    answered something that is no estimate of this recording. `refused`: it said in words that it cannot take it.
    """

    estimator: str
    status: Failure
    why: str  # one line
    trace: str = ""  # of Python, where it crashed


call_as(__name__, "imubench.run", "estimate")
