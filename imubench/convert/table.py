"""CSV tables of numbers, read by column name."""

import csv
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv

from imubench.arrays import Array
from imubench.errors import InputError, first_line

EMPTY = ["", "nan", "NaN", "NA", "null"]


@contextmanager
def reading(path: Path) -> Iterator[None]:
    """Turn whatever goes wrong while a file is read into one line that names the file."""
    try:
        yield
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: expected UTF-8 text, got byte {error.object[error.start]:#04x}") from None
    except FileNotFoundError:
        raise InputError(f"{path}: expected a file, got nothing of that name") from None
    except OSError as error:
        raise InputError(f"{path}: expected a readable file, got: {error.strerror or error}") from None
    except pa.ArrowInvalid as error:
        raise InputError(f"{path}: expected a table of numbers, got: {first_line(error)}") from None


def read_lines(path: Path, count: int) -> list[str]:
    """Return the first `count` lines of a text file, without line ends."""
    with reading(path), path.open(encoding="utf-8-sig", newline="") as file:
        lines = [file.readline() for _ in range(count)]
    if not lines[-1]:
        raise InputError(f"{path}: expected {count} header line{'s' * (count > 1)}, got fewer")
    return [line.rstrip("\r\n") for line in lines]


def read_columns(path: Path, columns: Sequence[str], header_line: int = 0, gaps: bool = False) -> dict[str, Array]:
    """Return the named columns, each (n,); names are on `header_line`, and with `gaps` an empty cell is NaN.

    Raises `InputError` for a file that cannot be read, a missing column, text, and (without `gaps`) an empty cell.
    """
    header = [name.strip() for name in next(csv.reader([read_lines(path, header_line + 1)[-1]]), [])]
    for name in columns:
        if name not in header:
            raise InputError(f"{path}: expected column '{name}', got {shortened(header)}")
        if header.count(name) > 1:
            raise InputError(f"{path}: expected column '{name}' once, got it {header.count(name)} times")
    wanted = list(dict.fromkeys(columns))
    with reading(path):
        table = pa.csv.read_csv(
            path,
            read_options=pa.csv.ReadOptions(skip_rows=header_line + 1, column_names=header),
            convert_options=pa.csv.ConvertOptions(
                include_columns=wanted, column_types=dict.fromkeys(wanted, pa.float64()), null_values=EMPTY
            ),
        )
    values = {name: np.asarray(table[name].to_numpy(), dtype=float) for name in wanted}
    for name, column in values.items():
        if not gaps and not np.isfinite(column).all():
            row = int(np.argmin(np.isfinite(column)))
            raise InputError(f"{path}, column '{name}', row {row}: expected a finite number, got {column[row]}")
    return values


def stack(table: dict[str, Array], columns: Sequence[str]) -> Array:
    """Return columns of a table side by side, (n, len(columns))."""
    return np.stack([table[name] for name in columns], axis=-1)


def shortened(names: Sequence[str], most: int = 10) -> str:
    """Return a list of names as text, cut after `most`."""
    return ", ".join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")
