"""The numbers of an effect: fitted ones with their priors, those that are read off, and how far they change."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from imubench.arrays import Array


@dataclass(frozen=True)
class Parameter:
    """One parameter of a law: its shape, unit, and how large it may plausibly be."""

    name: str
    shape: tuple[int, ...]  # () a number, (3,) an array
    unit: str
    std: float  # of the prior about `start`, in `unit`
    start: float | tuple[float, ...] = 0.0  # where a fit begins, and the prior's centre
    log: bool = False  # positive: the fit moves its logarithm, and `std` is that of the logarithm
    sided: bool = False  # nature knows it only at or above zero, though the fit may go below
    reported: bool = True  # False: the law needs it, the table of effects does not name it
    axes: Literal["sensor", "segment"] = "sensor"  # of three numbers: whose axes they are along or about
    about: bool = False  # whether they are about the axes, and not along them

    @property
    def width(self) -> int:
        """How many numbers it is."""
        return int(np.prod(self.shape, dtype=int))

    @property
    def centre(self) -> Array:
        """The prior's centre (k,) in the fit's variable."""
        start = np.broadcast_to(np.asarray(self.start, dtype=float).reshape(-1), (self.width,))
        return np.log(start) if self.log else start.copy()


@dataclass(frozen=True)
class Found:
    """A parameter that is read off the raw samples or the fitted states, not fitted itself."""

    name: str
    shape: tuple[int | None, ...]  # None: any number of them
    unit: str


@dataclass(frozen=True)
class Change:
    """How far the numbers of an effect go from one recording of a sensor to the next, as standard deviations."""

    std: float = 0.0  # in the number's unit
    share: float = 0.0  # of the number

    def of(self, value: Array) -> Array:
        """Return the standard deviations (k,) of numbers (k,)."""
        return np.asarray(np.hypot(self.std, self.share * value))


__all__ = ["Change", "Found", "Parameter"]
