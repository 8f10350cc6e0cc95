"""CSV tables of a converter's source, read by column name."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from imubench.arrays import Array
from imubench.errors import InputError
from imubench.inputs.csv import Form, read_csv, read_header, read_lines
from imubench.inputs.tables import check_numbers, listed

EMPTY = ("", "nan", "NaN", "NA", "null")


def read_columns(path: Path, columns: Sequence[str], header_line: int = 0, gaps: bool = False) -> dict[str, Array]:
    """Return the named columns, each (n,).

    Args:
        path: a CSV file.
        columns: their names; one may be asked for more than once.
        header_line: lines above the header, which are passed over.
        gaps: whether an empty cell is NaN; it is an error otherwise.

    Raises:
        InputError: a file that cannot be read, a missing column, text, and (without `gaps`) an empty cell.
    """
    asked = list(dict.fromkeys(columns))

    def choose(header: Sequence[str]) -> list[str]:
        for name in asked:
            if name not in header:
                raise InputError(f"{path}: expected column '{name}', got {listed(header, 10)}")
            if header.count(name) > 1:
                raise InputError(f"{path}: expected column '{name}' once, got it {header.count(name)} times")
        return asked

    table = read_csv(path, choose, form=Form(header_line, EMPTY))
    check_numbers(table)
    for name, column in table.columns.items():
        if not gaps and not np.isfinite(column).all():
            row = int(np.argmin(np.isfinite(column)))
            raise InputError(f"{table.place(row)}, column '{name}': expected a finite number, got {column[row]}")
    return dict(table.columns)


def stack(table: dict[str, Array], columns: Sequence[str]) -> Array:
    """Return columns of a table side by side, (n, len(columns))."""
    return np.stack([table[name] for name in columns], axis=-1)


__all__ = ["read_columns", "read_header", "read_lines", "stack"]
