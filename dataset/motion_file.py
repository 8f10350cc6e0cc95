"""A motion of one's own: a table of angles and coordinates over time, made smooth by splines of degree 5."""

import io
from dataclasses import dataclass

import numpy as np
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet
from scipy.interpolate import PPoly, make_interp_spline

from imubench.arrays import Array, frozen, frozen_time
from imubench.errors import InputError, first_line, unknown
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
        table = _table(content, name)
        if "time" not in table.column_names:
            raise InputError(f"{name}: expected a column 'time', got {', '.join(table.column_names)}")
        for column in table.column_names:
            if column not in ("time", *COLUMNS):
                raise unknown(f"column in {name}", column, ("time", *COLUMNS))
        if table.num_rows <= DEGREE:
            raise InputError(f"{name}: expected {DEGREE + 1} rows or more, got {table.num_rows}")
        time = frozen_time(_numbers(table, "time", name), f"{name}: time")
        time = time - time[0]
        columns = {
            c: frozen(_numbers(table, c, name), (None,), f"{name}: {c}") for c in COLUMNS if c in table.column_names
        }
        signals = {c: Interpolated(time, values) for c, values in columns.items()}
        return cls(AngleMotion(**signals), float(time[-1]))


def _table(content: bytes, name: str) -> pa.Table:
    try:
        if name.endswith(".parquet"):
            return pyarrow.parquet.read_table(io.BytesIO(content))
        if name.endswith(".csv"):
            return pyarrow.csv.read_csv(io.BytesIO(content))
    except pa.ArrowInvalid as error:
        raise InputError(f"{name}: expected a table, got: {first_line(error)}") from None
    raise InputError(f"{name}: expected a .csv or .parquet file")


def _numbers(table: pa.Table, column: str, name: str) -> Array:
    try:
        return np.asarray(table.column(column).cast(pa.float64()).to_numpy(), dtype=float)
    except pa.ArrowInvalid as error:
        raise InputError(f"{name}: {column}: expected numbers, got: {first_line(error)}") from None
