"""Columns of numbers in CSV and Parquet files, read with messages that name the line, written without any loss."""

import csv
import io
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet

from imubench.arrays import Array
from imubench.errors import InputError

Place = Callable[[int], str]
"""Takes a row of the columns, counted from 0; says where that is: `imu1.csv, line 7`."""

THREADS = False  # Arrow's pool can end a process with "terminate called" (apache/arrow issue 34314)
HEADER = re.compile(r"\ufeff?(?:[ \t]*(?:\r\n|\n|\r))*([^\r\n]*)(?:\r\n|\n|\r|$)")


@dataclass(frozen=True)
class Table:
    """Columns (n,) of one file, and where each of their rows stands in it."""

    columns: Mapping[str, Array]
    place: Place

    def stack(self, names: Sequence[str]) -> Array:
        """Return columns side by side, (n, len(names)); a column that the file does not have is NaN."""
        empty = np.full(len(next(iter(self.columns.values()))), np.nan)
        return np.stack([self.columns.get(name, empty) for name in names], axis=-1)


def read_table(path: Path, required: Sequence[str], optional: Sequence[str] | None = None) -> Table:
    """Return the named columns of a .csv or .parquet file; its `time` must increase, in s.

    Required columns are finite. Optional ones are there or not and may have empty cells (NaN); with `optional=None`
    other columns are passed over, otherwise they are errors. Raises `InputError` with file and line (CSV, counted
    from 1 as an editor does) or row (Parquet, from 1) for everything that is not a table of such numbers.
    """
    read = {".csv": _read_csv, ".parquet": _read_parquet}.get(path.suffix.lower())
    if read is None:
        raise InputError(f"{path}: expected a .csv or .parquet file, got '{path.suffix}'")
    table = read(path, read_bytes(path), required, optional)
    for name, column in table.columns.items():
        wrong = ~np.isfinite(column) if name in required else np.isinf(column)
        if wrong.any():
            row = int(wrong.argmax())
            got = "an empty cell or NaN" if np.isnan(column[row]) else f"{column[row]}"
            raise InputError(f"{table.place(row)}, column '{name}': expected a finite number, got {got}")
    _check_time(table)
    return table


def read_bytes(path: Path) -> bytes:
    """Return a file's content; `InputError` when it is missing (or gone meanwhile), a folder or unreadable."""
    try:
        return path.read_bytes()
    except FileNotFoundError:
        raise InputError(f"{path}: expected a file, got nothing of that name") from None
    except IsADirectoryError:
        raise InputError(f"{path}: expected a file, got a folder") from None
    except (OSError, ValueError) as error:  # ValueError: a name with a null character
        raise InputError(f"{path}: expected a readable file, got: {getattr(error, 'strerror', error)}") from None


def what_is(path: Path) -> str:
    """Return `a file`, `a folder` or `nothing of that name`, which also a name too long for any file is."""
    try:
        return "a folder" if path.is_dir() else "a file" if path.exists() else "nothing of that name"
    except OSError:
        return "nothing of that name"


def decode(path: Path, content: bytes) -> str:
    """Return text; `InputError` names the line of the first byte that is not UTF-8."""
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise InputError(f"{path}, line {line}: expected UTF-8 text, got byte 0x{content[error.start]:02x}") from None


def write_table(path: Path, columns: Mapping[str, Array]) -> None:
    """Write columns (n,) as .csv or .parquet; NaN becomes an empty cell, and every other bit comes back as it was."""
    for name, column in columns.items():
        if np.isinf(column).any():
            row = int(np.isinf(column).argmax())
            raise InputError(
                f"{path.name}, column '{name}', row {row + 1}: expected a number or NaN, got {column[row]}"
            )
    table = pa.table({name: pa.array(column, type=pa.float64(), from_pandas=True) for name, column in columns.items()})
    if path.suffix == ".parquet":
        pa.parquet.write_table(table, path)
        return
    with path.open("wb") as file:
        file.write((",".join(columns) + "\n").encode())  # Arrow would put the names in quotes
        pa.csv.write_csv(table, file, pa.csv.WriteOptions(include_header=False))


def _read_csv(path: Path, content: bytes, required: Sequence[str], optional: Sequence[str] | None) -> Table:
    text = decode(path, content)
    head = HEADER.match(text)
    if head is None or not head[1].strip():
        raise InputError(f"{path}: expected a header and rows of numbers, got an empty file")
    header = [name.strip() for name in next(csv.reader([head[1]]))]
    wanted = _wanted(path, header, required, optional)
    body, above = text[head.end() :], len(text[: head.end()].splitlines())
    if not body.strip():
        raise InputError(f"{path}: expected rows of numbers below the header, got none")
    try:
        table = pa.csv.read_csv(
            pa.BufferReader(body.encode()),
            read_options=pa.csv.ReadOptions(column_names=header, use_threads=THREADS),
            convert_options=pa.csv.ConvertOptions(
                include_columns=wanted,
                column_types=dict.fromkeys(wanted, pa.float64()),
                null_values=[""],
                quoted_strings_can_be_null=True,
            ),
        )
    except (pa.ArrowException, UnicodeError) as error:
        raise _csv_error(path, header, wanted, body, above, str(error)) from None
    columns = {name: np.asarray(table[name].to_numpy(), dtype=float) for name in wanted}
    return Table(columns, lambda row: f"{path}, line {_lines(body, above)[row][0]}")


def _lines(body: str, above: int) -> list[tuple[int, list[str]]]:
    """Return (line in the file from 1, cells) of every row: slow, and only needed to say where an error is."""
    reader = csv.reader(io.StringIO(body, newline=""))
    return [(above + reader.line_num, cells) for cells in reader if cells]


def _csv_error(
    path: Path, header: Sequence[str], wanted: Sequence[str], body: str, above: int, reason: str
) -> InputError:
    """Return the error for the first row that is not one of numbers, found by looking at each."""
    try:
        lines = _lines(body, above)
    except csv.Error as error:
        return InputError(f"{path}: expected rows of numbers, got: {error}")
    places = [(name, header.index(name)) for name in wanted]
    for line, cells in lines:
        if len(cells) != len(header):
            return InputError(f"{path}, line {line}: expected {len(header)} cells, as in the header, got {len(cells)}")
        for name, k in places:
            if not _is_number(cells[k]):
                got = cells[k] if len(cells[k]) <= 40 else cells[k][:40] + "..."
                return InputError(f"{path}, line {line}, column '{name}': expected a number, got {got!r}")
    return InputError(f"{path}: expected rows of numbers, got: {reason.splitlines()[0][:200]}")


def _is_number(cell: str) -> bool:
    """Say whether a cell is a number as Arrow understands it; an empty one counts."""
    if not cell.strip():
        return True
    try:
        float(cell)
    except ValueError:
        return False
    return "_" not in cell  # Python takes 1_000 for a thousand


def _read_parquet(path: Path, content: bytes, required: Sequence[str], optional: Sequence[str] | None) -> Table:
    if not content:
        raise InputError(f"{path}: expected a Parquet table, got an empty file")
    try:
        file = pa.parquet.ParquetFile(pa.BufferReader(content))
        schema = file.schema_arrow
        wanted = _wanted(path, schema.names, required, optional)
        for name in wanted:
            kind = schema.field(name).type
            if not (pa.types.is_floating(kind) or pa.types.is_integer(kind) or pa.types.is_decimal(kind)):
                raise InputError(f"{path}, column '{name}': expected numbers, got {kind}")
        table = file.read(columns=wanted, use_threads=THREADS)
        numbers = {name: table[name].cast(pa.float64(), safe=False) for name in wanted}
    except (pa.ArrowException, OSError, UnicodeError) as error:
        reason = str(error).splitlines()[0][:200]
        raise InputError(f"{path}: expected a readable Parquet table, got: {reason}") from None
    if table.num_rows == 0:
        raise InputError(f"{path}: expected rows of numbers, got none")
    columns = {name: np.asarray(column.to_numpy(), dtype=float) for name, column in numbers.items()}
    return Table(columns, lambda row: f"{path}, row {row + 1}")


def _wanted(path: Path, header: Sequence[str], required: Sequence[str], optional: Sequence[str] | None) -> list[str]:
    """Return the required columns and the optional ones that are there."""
    known = [*required, *(optional or ())]
    listed = ", ".join(header[:12]) + (f" and {len(header) - 12} more" if len(header) > 12 else "")
    for name in required:
        if name not in header:
            raise InputError(f"{path}: expected column '{name}', got columns {listed}")
    for name in header:
        if name in known and header.count(name) > 1:
            raise InputError(f"{path}: expected column '{name}' once, got it {header.count(name)} times")
        if optional is not None and name not in known:
            raise InputError(f"{path}: unknown column '{name}'; known: {', '.join(known)}")
    return [name for name in known if name in header]


def _check_time(table: Table) -> None:
    time = table.columns["time"]
    step = np.diff(time)
    if (step <= 0).any():
        row = int((step <= 0).argmax()) + 1
        what = "a repeated stamp" if step[row - 1] == 0 else "time running backwards"
        raise InputError(
            f"{table.place(row)}, column 'time': expected increasing time, got {what}: "
            f"{time[row]:.12g} s after {time[row - 1]:.12g} s"
        )
