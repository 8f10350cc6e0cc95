"""Measurements as rows of a least-squares problem."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from imubench.arrays import Array
from imubench.diagnosis.problem.bspline import place_of
from imubench.jets import Jet

CHANNELS = {"gyro": ("gyr_x", "gyr_y", "gyr_z"), "accel": ("acc_x", "acc_y", "acc_z")}


@dataclass(frozen=True)
class Rows:
    """Residuals of one kind, model minus measurement, whitened: `std` is one standard deviation."""

    name: str  # as "imu1.gyro"
    time: Array  # (n,) s, where on the splines
    residual: Jet  # (n, m), in the unit of `std`
    std: Array  # (m,) or (n, m)
    counts: bool = True  # False: a prior, not a measurement
    level: float = 1.0  # the noise level that `std` holds, where one is estimated

    def at_level(self, level: float) -> "Rows":
        """Return the rows at another noise level."""
        return replace(self, std=self.std * (level / self.level), level=level)

    @property
    def whitened(self) -> Array:
        """Residuals (n, m) over their standard deviation."""
        return self.residual.value / self.std

    @property
    def log_std(self) -> Array:
        """Natural logarithms of the standard deviations (n, m)."""
        return np.log(np.broadcast_to(self.std, self.residual.value.shape))

    @property
    def cost(self) -> float:
        """Half the sum of the squares."""
        return 0.5 * float(np.sum(self.whitened**2))


@dataclass(frozen=True)
class Parameters:
    """The numbers that the whole recording shares, by name: where each lies in one vector."""

    widths: dict[str, int]

    @property
    def count(self) -> int:
        """How many numbers there are."""
        return sum(self.widths.values())

    def places(self, names: Sequence[str]) -> NDArray[np.intp]:
        """Return where the numbers of some parameters lie in the vector, in this order."""
        return np.concatenate([np.r_[self.columns(name)] for name in names])

    def columns(self, name: str) -> slice:
        """Return where a parameter lies in the vector."""
        return place_of(self.widths, name)


SWING_EQUATION = "swing.torque"


def is_data(rows: Rows) -> bool:
    """Return whether rows are samples, or the equation of motion in free swings."""
    return rows.counts or rows.name == SWING_EQUATION


def equation_of(rows: Iterable[Rows]) -> Rows | None:
    """Return the equation of motion among the rows of a fit; None where nothing swings freely."""
    return next((r for r in rows if r.name == SWING_EQUATION), None)
