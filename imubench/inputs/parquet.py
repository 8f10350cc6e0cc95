"""Parquet tables, whose sizes are read from their footer before any row is."""

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import IO, Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet

from imubench.errors import InputError, first_line
from imubench.inputs.files import opened
from imubench.inputs.limits import BINARY_BYTES, COLUMNS
from imubench.inputs.tables import Table, check_header, check_size

BATCH = 1 << 16  # rows read at a time


@contextmanager
def parquet_errors(where: str) -> Iterator[None]:
    """Turn whatever Arrow says of a damaged file into one line that names the file."""
    try:
        yield
    except InputError:
        raise
    except (pa.ArrowException, OSError, UnicodeError, ValueError, KeyError, IndexError, OverflowError) as error:
        reason = first_line(error)
        raise InputError(f"{where}: expected a readable Parquet table, got: {reason}") from None


@contextmanager
def opened_parquet(source: Path | IO[bytes], where: str) -> Iterator[Any]:
    """Hand out an open Parquet file whose footer is within the limits.

    Args:
        source: a path, or an open file of a storage.
        where: its name, for messages.

    Raises:
        InputError: no regular file, no Parquet, damaged, too large, or with more columns than the limit.
    """
    with parquet_errors(where):
        if isinstance(source, Path):
            with opened(source, BINARY_BYTES) as file, pa.parquet.ParquetFile(file) as table:
                yield _within(table, where)
        else:
            with pa.parquet.ParquetFile(source) as table:
                yield _within(table, where)


def _within(table: Any, where: str) -> Any:
    if table.metadata.num_columns > COLUMNS:
        raise InputError(f"{where}: expected at most {COLUMNS:,} columns, got {table.metadata.num_columns:,}")
    names = table.schema_arrow.names
    if twice := [name for name, count in Counter(names).items() if count > 1]:
        raise InputError(f"{where}: expected each column once, got '{twice[0]}' more often")
    for field in table.schema_arrow:
        width = _width(field.type)
        if width > COLUMNS:  # a null of such a list takes as much memory as its numbers would
            at = f"{where}, column '{field.name}'"
            raise InputError(f"{at}: expected at most {COLUMNS:,} values a row, got {width:,}")
    return table


def _width(kind: Any) -> int:
    """Return how many values, or bytes, a row of this type takes at least, whatever it holds."""
    if pa.types.is_fixed_size_binary(kind):
        return int(kind.byte_width)
    if pa.types.is_fixed_size_list(kind):
        return int(kind.list_size) * _width(kind.value_type)
    if pa.types.is_struct(kind):
        return sum(_width(kind.field(i).type) for i in range(kind.num_fields))
    return 1


def read_parquet(path: Path, choose: Callable[[Sequence[str]], list[str]], content: bytes | None = None) -> Table:
    """Return columns of numbers; a null is NaN.

    Args:
        path: the file.
        choose: takes the names of its columns and returns those to read; raises `InputError` where one is not there.
        content: what the file holds, where it was read before.

    Raises:
        InputError: no Parquet, damaged, a column that holds no numbers, no row, or beyond the limits.
    """
    with opened_parquet(path if content is None else BytesIO(content), str(path)) as file:
        schema = file.schema_arrow
        check_header(path, schema.names)
        names = choose(schema.names)
        for name in names:
            kind = schema.field(name).type
            if not (pa.types.is_floating(kind) or pa.types.is_integer(kind) or pa.types.is_decimal(kind)):
                raise InputError(f"{path}, column '{name}': expected numbers, got {kind}")
        check_size(path, file.metadata.num_rows, len(names))
        rows, parts = 0, []
        for batch in file.iter_batches(BATCH, columns=names, use_threads=False):
            rows += batch.num_rows  # the footer may say less
            check_size(path, rows, len(names))
            parts.append([np.asarray(batch.column(n).cast(pa.float64(), safe=False), dtype=float) for n in names])
    if not rows:
        raise InputError(f"{path}: expected rows of numbers, got none")
    columns = {name: np.concatenate([part[k] for part in parts]) for k, name in enumerate(names)}
    return Table(columns, lambda row: f"{path}, row {row + 1}")
