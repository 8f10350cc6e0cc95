"""CSV tables of numbers, read block by block, so that memory holds the numbers and never the text."""

import csv
import io
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np
import pyarrow as pa
import pyarrow.csv

from imubench.arrays import Array
from imubench.errors import InputError, first_line, shown
from imubench.inputs.files import decode, opened
from imubench.inputs.limits import LINE_CHARACTERS, TABLE_BYTES
from imubench.inputs.tables import Table, check_header, check_size

THREADS = False  # Arrow's pool can end a process with "terminate called" (apache/arrow issue 34314)
BLOCK = 1 << 21  # bytes of text parsed at a time
EMPTY = ("",)  # cells that hold no number, in format 1


@dataclass(frozen=True)
class Form:
    """How a CSV file is laid out."""

    above: int = 0  # lines above the header that are passed over, such as comments
    empty: Sequence[str] = EMPTY  # cells that stand for no number: NaN


@dataclass
class _Block:
    """Whole lines of the file."""

    text: bytes
    start: int  # byte in the file
    line: int  # of its first line, from 1
    rows: int = 0  # above it


def read_csv(
    path: Path, choose: Callable[[Sequence[str]], list[str]], content: bytes | None = None, form: Form | None = None
) -> Table:
    """Return columns of numbers; an empty cell is NaN.

    Args:
        path: the file, UTF-8.
        choose: takes the header's names and returns those to read; raises `InputError` where one is not there.
        content: what the file holds, where it was read before.
        form: how the file is laid out; None: a header on the first line that is not empty.

    Raises:
        InputError: with the line, for a cell that is no number or a row of another length; without one, for a file
            that holds no table or is beyond the limits.
    """
    form = form or Form()
    with opened(path, TABLE_BYTES, content) as file:
        header, start, line = _header(path, file, form)
        check_header(path, header)
        names = choose(header)
        blocks: list[_Block] = []
        found: list[list[Array]] = []
        rows = 0
        for block in _blocks(path, file, start, line):
            columns = _parsed(path, block, header, names, form)
            block.rows, block.text = rows, b""
            blocks.append(block)
            if columns:  # a block may hold blank lines alone
                found.append(columns)
                rows += len(columns[0])
            check_size(path, rows, len(names))
    if not rows:
        raise InputError(f"{path}: expected rows of numbers below the header, got none")
    values = {name: np.concatenate([columns[k] for columns in found]) for k, name in enumerate(names)}
    return Table(values, lambda row: f"{path}, line {_line_of(path, content, blocks, row)}")


def read_header(path: Path, form: Form | None = None) -> list[str]:
    """Return the names in the header of a CSV file; `InputError` where it has none."""
    with opened(path, TABLE_BYTES) as file:
        return _header(path, file, form or Form())[0]


def read_lines(path: Path, count: int) -> list[str]:
    """Return the first `count` lines of a text file, without line ends; `InputError` where there are fewer."""
    with opened(path, TABLE_BYTES) as file:
        lines = [_text_line(path, file, number + 1) for number in range(count)]
    if not lines[-1]:
        raise InputError(f"{path}: expected {count} header line{'s' * (count > 1)}, got fewer")
    return [line.rstrip("\r\n") for line in lines]


def _header(path: Path, file: BinaryIO, form: Form) -> tuple[list[str], int, int]:
    """Return the header's names, the byte at which rows begin, and the number of the line there."""
    line = 1
    for _ in range(form.above):
        _text_line(path, file, line)
        line += 1
    while True:
        text = _text_line(path, file, line)
        if not text:
            raise InputError(f"{path}: expected a header and rows of numbers, got an empty file")
        first, *more = text.splitlines(keepends=True)  # more: a file of an old system, whose lines end in \r
        if more:
            file.seek(file.tell() - len("".join(more).encode()))
        line += 1
        if first.strip("\ufeff \t\r\n"):
            break
    try:
        names = next(csv.reader([first.lstrip("\ufeff").rstrip("\r\n")], strict=True))
    except csv.Error as error:
        raise InputError(f"{path}, line {line - 1}: expected a header, got: {error}") from None
    return [name.strip() for name in names], file.tell(), line


def _text_line(path: Path, file: BinaryIO, number: int) -> str:
    content = file.readline(LINE_CHARACTERS + 1)
    if len(content) > LINE_CHARACTERS:
        raise _too_long(path, number)
    return decode(content, str(path), number)


def _too_long(path: Path, line: int) -> InputError:
    return InputError(f"{path}, line {line}: expected a line of at most {LINE_CHARACTERS:,} bytes, got a longer one")


def _blocks(path: Path, file: BinaryIO, start: int, line: int) -> Iterator[_Block]:
    """Yield whole lines, about `BLOCK` bytes at a time."""
    file.seek(start)
    rest = b""
    while True:
        content = file.read(BLOCK)
        text = rest + content
        if not text:
            return
        end = len(text) if not content else 1 + max(text.rfind(b"\n"), _last_return(text))
        if end == 0 or (content and len(text) - end > LINE_CHARACTERS):
            if len(text) - end > LINE_CHARACTERS:
                lines = text[:end].count(b"\n")
                raise _too_long(path, line + lines)
            rest = text
            continue
        whole, rest = text[:end], text[end:]
        yield _Block(whole, start, line)
        start += end
        line += _count_lines(whole)


def _last_return(text: bytes) -> int:
    r"""Return where the last `\r` is that surely ends a line: not the last byte, which `\n` may follow."""
    return -1 if b"\n" in text else text.rfind(b"\r", 0, len(text) - 1)


def _count_lines(text: bytes) -> int:
    return text.count(b"\n") or text.count(b"\r")


def _parsed(path: Path, block: _Block, header: Sequence[str], names: list[str], form: Form) -> list[Array]:
    """Return the columns of a block's rows, in the order of `names`."""
    if not block.text.strip():
        return []
    decode(block.text, str(path), block.line)
    try:
        table = pa.csv.read_csv(
            pa.BufferReader(block.text),
            read_options=pa.csv.ReadOptions(
                column_names=list(header), use_threads=THREADS, block_size=len(block.text) + 1
            ),
            convert_options=pa.csv.ConvertOptions(
                include_columns=names,
                column_types=dict.fromkeys(names, pa.float64()),
                null_values=list(form.empty),
                quoted_strings_can_be_null=True,
            ),
        )
    except (pa.ArrowException, UnicodeError) as error:
        raise _wrong_row(path, block, header, names, form, first_line(error)) from None
    return [np.asarray(table.column(name).to_numpy(), dtype=float) for name in names]


def _rows(block: _Block) -> list[tuple[int, list[str]]]:
    """Return (line in the file from 1, cells) of every row: slow, and only needed to say where an error is."""
    reader = csv.reader(io.StringIO(block.text.decode(), newline=""))
    return [(block.line - 1 + reader.line_num, cells) for cells in reader if cells]


def _wrong_row(
    path: Path, block: _Block, header: Sequence[str], names: list[str], form: Form, reason: str
) -> InputError:
    """Return the error for the first row of a block that is not one of numbers."""
    try:
        rows = _rows(block)
    except csv.Error as error:
        return InputError(f"{path}: expected rows of numbers, got: {error}")
    places = [(name, header.index(name)) for name in names]
    for line, cells in rows:
        if len(cells) != len(header):
            return InputError(f"{path}, line {line}: expected {len(header)} cells, as in the header, got {len(cells)}")
        for name, k in places:
            if cells[k] not in form.empty and not _is_number(cells[k]):
                return InputError(f"{path}, line {line}, column '{name}': expected a number, got {shown(cells[k], 50)}")
    return InputError(f"{path}, from line {block.line} on: expected rows of numbers, got: {reason}")


def _is_number(cell: str) -> bool:
    """Say whether a cell is a number as Arrow understands it; an empty one counts."""
    if not cell.strip():
        return True
    try:
        float(cell)
    except ValueError:
        return False
    return "_" not in cell  # Python takes 1_000 for a thousand


def _line_of(path: Path, content: bytes | None, blocks: Sequence[_Block], row: int) -> int:
    """Return the line in the file, from 1, of a row of the columns; reads its block again."""
    k = int(np.searchsorted([b.rows for b in blocks], row, side="right")) - 1
    block, after = blocks[k], blocks[k + 1].start if k + 1 < len(blocks) else None
    with opened(path, TABLE_BYTES, content) as file:
        file.seek(block.start)
        text = file.read() if after is None else file.read(after - block.start)
    rows = _rows(_Block(text, block.start, block.line))
    return rows[min(row - block.rows, len(rows) - 1)][0] if rows else block.line
