"""A motion of one's own: a table of angles and coordinates over time, made smooth by splines of degree 5."""

from dataclasses import dataclass
from pathlib import Path

from scipy.interpolate import PPoly, make_interp_spline

from imubench.arrays import Array, frozen, frozen_time
from imubench.errors import InputError
from imubench.inputs.tables import read_table
from imubench.sim.motion import AngleMotion
from imubench.sim.signals import check_within, with_derivatives

COLUMNS = ("heading", "tilt", "spin", "angle", "x", "y", "z")
"""What may stand beside `time`, in rad and m; what is not there stays at zero. Their meaning is `AngleMotion`'s."""

DEGREE = 5


class Interpolated:
    """A spline of degree 5 through given values: four times differentiable, and defined from the first to the last."""

    def __init__(self, time: Array, values: Array) -> None:
        self._pieces = with_derivatives(PPoly.from_spline(make_interp_spline(time, values, DEGREE)))
        self.start, self.end = float(time[0]), float(time[-1])  # s

    def __call__(self, time: Array) -> tuple[Array, Array, Array]:
        """Return value and derivatives at `time`; `InputError` beyond the given ones."""
        check_within(time, self.start, self.end)
        value, first, second = self._pieces(time).T
        return value, first, second


@dataclass(frozen=True)
class MotionFile:
    """A motion that starts at time 0, whatever the file's clock says."""

    motion: AngleMotion
    duration: float  # s

    @classmethod
    def parse(cls, content: bytes, name: str) -> "MotionFile":
        """Return the motion in the bytes of a .csv or .parquet file.

        Raises `InputError` for another file, a column that is none of `COLUMNS`, time that does not increase,
        a value that is no finite number, or fewer than 6 rows.
        """
        table = read_table(Path(name), ["time"], COLUMNS, content)
        time = table.columns["time"]
        if time.size <= DEGREE:
            raise InputError(f"{name}: expected {DEGREE + 1} rows or more, got {time.size}")
        time = frozen_time(time - time[0], f"{name}: time")
        columns = {c: frozen(values, (None,), f"{name}: {c}") for c, values in table.columns.items() if c != "time"}
        signals = {c: Interpolated(time, values) for c, values in columns.items()}
        return cls(AngleMotion(**signals), float(time[-1]))
