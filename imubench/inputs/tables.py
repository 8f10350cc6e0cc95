"""Columns of numbers in CSV and Parquet files, read with messages that name the line."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from imubench.arrays import SHORTEST_STEP, Array
from imubench.errors import InputError, shortened, unknown
from imubench.inputs.limits import COLUMNS, NUMBERS, SIZE

Place = Callable[[int], str]
"""Takes a row of the columns, counted from 0; says where that is: `imu1.csv, line 7`."""


@dataclass(frozen=True)
class Table:
    """Columns (n,) of one file, and where each of their rows stands in it."""

    columns: Mapping[str, Array]
    place: Place

    def stack(self, names: Sequence[str]) -> Array:
        """Return columns side by side, (n, len(names)); a column that the file does not have is NaN."""
        empty = np.full(len(next(iter(self.columns.values()))), np.nan)
        return np.stack([self.columns.get(name, empty) for name in names], axis=-1)


def read_table(
    path: Path, required: Sequence[str], optional: Sequence[str] | None = None, content: bytes | None = None
) -> Table:
    """Return the named columns of a .csv or .parquet file; its `time` must increase, in s.

    Args:
        path: the file.
        required: columns that must be there, finite in every row; `time` is one of them.
        optional: columns that are there or not and may have empty cells (NaN); any other column is then an error.
            None: other columns are passed over.
        content: what the file holds, where it was read before.

    Raises:
        InputError: with file and line (CSV, counted from 1 as an editor does) or row (Parquet, from 1) for everything
            that is not a table of such numbers, and for one beyond the limits.
    """
    from imubench.inputs.csv import read_csv
    from imubench.inputs.parquet import read_parquet

    readers: Mapping[str, Callable[..., Table]] = {".csv": read_csv, ".parquet": read_parquet}
    read = readers.get(path.suffix.lower())
    if read is None:
        raise InputError(f"{path}: expected a .csv or .parquet file, got '{path.suffix}'")
    table = read(path, lambda header: wanted(path, header, required, optional), content)
    for name, column in table.columns.items():
        wrong = ~np.isfinite(column) if name in required else np.isinf(column)
        if wrong.any():
            row = int(wrong.argmax())
            got = "an empty cell or NaN" if np.isnan(column[row]) else f"{column[row]}"
            raise InputError(f"{table.place(row)}, column '{name}': expected a finite number, got {got}")
    check_numbers(table)
    check_time(table)
    return table


def check_numbers(table: Table) -> None:
    """Raise `InputError` for a number beyond the limit; NaN and infinity are others' business."""
    for name, column in table.columns.items():
        wrong = np.isfinite(column) & (np.abs(column) > SIZE)
        if wrong.any():
            row = int(wrong.argmax())
            raise InputError(f"{table.place(row)}, column '{name}': expected at most {SIZE:g}, got {column[row]:g}")


def wanted(path: Path, header: Sequence[str], required: Sequence[str], optional: Sequence[str] | None) -> list[str]:
    """Return the required columns and the optional ones that are in a header; `InputError` as `read_table`."""
    check_header(path, header)
    known = [*required, *(optional or ())]
    for name in required:
        if name not in header:
            raise InputError(f"{path}: expected column '{name}', got columns {listed(header)}")
    for name in header:
        if name in known and header.count(name) > 1:
            raise InputError(f"{path}: expected column '{name}' once, got it {header.count(name)} times")
        if optional is not None and name not in known:
            raise InputError(f"{path}: {unknown('column', name, known)}")
    return [name for name in known if name in header]


def check_header(path: Path, header: Sequence[str]) -> None:
    """Raise `InputError` for more columns than the limit."""
    if len(header) > COLUMNS:
        raise InputError(f"{path}: expected at most {COLUMNS:,} columns, got {len(header):,}")


def check_size(path: Path, rows: int, columns: int) -> None:
    """Raise `InputError` for more numbers than the limit."""
    if rows * columns > NUMBERS:
        most = NUMBERS // max(columns, 1)
        raise InputError(f"{path}: expected at most {most:,} rows of {columns} columns, got {rows:,} or more")


def listed(names: Sequence[str], most: int = 12) -> str:
    """Return names as text, cut after `most`."""
    return ", ".join(shortened(n, 40) for n in names[:most]) + (
        f" and {len(names) - most} more" if len(names) > most else ""
    )


def check_time(table: Table) -> None:
    """Raise `InputError` unless the column `time` increases from row to row."""
    time = table.columns["time"]
    step = np.diff(time)
    if (step < SHORTEST_STEP).any():
        row = int((step < SHORTEST_STEP).argmax()) + 1
        what = "a repeated stamp" if step[row - 1] >= 0 else "time running backwards"
        raise InputError(
            f"{table.place(row)}, column 'time': expected increasing time, got {what}: "
            f"{time[row]:.12g} s after {time[row - 1]:.12g} s"
        )
