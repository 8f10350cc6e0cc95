"""Columns of numbers written as CSV or Parquet without any loss."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet

from imubench.arrays import Array
from imubench.errors import InputError


def write_table(path: Path, columns: Mapping[str, Array]) -> None:
    """Write columns (n,) as .csv or .parquet; NaN becomes an empty cell, and every other bit comes back as it was."""
    for name, column in columns.items():
        if np.isinf(column).any():
            row = int(np.isinf(column).argmax())
            raise InputError(
                f"{path.name}, column '{name}', row {row + 1}: expected a number or NaN, got {column[row]}"
            )
    table = pa.table({name: pa.array(column, type=pa.float64(), from_pandas=True) for name, column in columns.items()})
    with path.open("wb") as file:  # Python's, which goes on where a write is interrupted or cut short; Arrow's does not
        if path.suffix == ".parquet":
            pa.parquet.write_table(table, file)
        else:
            file.write((",".join(columns) + "\n").encode())  # Arrow would put the names in quotes
            pa.csv.write_csv(table, file, pa.csv.WriteOptions(include_header=False))
