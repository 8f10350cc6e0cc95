"""What a command wrote, without what may differ from run to run: measured times and Rerun's own numbers."""

import hashlib
import json
import re
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

MARKER = ".imubench.json"  # sizes and times of change
TIMED = ("proof.json", "diagnosis.json")
"""Our JSON files with run times: the values of every key `seconds`, and the proof's figure of that name."""

STAGE = re.compile(r"^\d+ of \d+, \d+ s: .*\n", re.MULTILINE)
"""What a command says of a stage that began after two seconds, where nobody sees a bar: on a slow machine alone."""

SHOWN_TIMES = re.compile(r"\d+\.\d s(?=\. The same in numbers)|(?<=seconds for a diagnosis, median</td>).*?(?=</td>)")
"""Run times in our reports."""

TIMED_TABLE = re.compile(r"<table>(?:(?!</table>).)*?<th>s</th></tr>.*?</table>", flags=re.DOTALL)
"""A table of our reports whose last column is a run time in s."""

SEALED = re.compile(r".*\.(commitment|sealed)\.json")
"""Files of `prove --seal`, whose salt is drawn anew each time, and their keys that depend on it."""

SALTED = ("salt", "truth")
UUID = re.compile(r"[0-9a-f]{8}-(?:[0-9a-f]{4}-){3}[0-9a-f]{12}")
ROW = "rerun.controls.RowId"
DRAWN = ("log_time", "RecordingInfo:start_time", "ViewportBlueprint:root_container")
"""Columns of a .rrd file that hold the time of day at which it was made, or a random number."""


def content(path: Path) -> dict[str, object]:
    """Return what is in a file or below a folder, by relative path."""
    if path.is_file():
        return {path.name: one(path)}
    return {p.relative_to(path).as_posix(): one(p) if p.is_file() else "a folder" for p in sorted(path.rglob("*"))}


def one(file: Path) -> object:
    """Return what is in a file; the bytes of what is hidden, which may be half of something."""
    if file.name == MARKER:
        with suppress(json.JSONDecodeError):  # half of it is in the hidden folder of a run that was killed
            return sorted(json.loads(file.read_text()))
    if file.name.startswith("."):
        return file.read_bytes()
    if file.name in TIMED:
        return timeless(json.loads(file.read_text()))
    if file.name == "report.html":
        text = SHOWN_TIMES.sub("", file.read_text())
        return TIMED_TABLE.sub(lambda table: re.sub(r"<td>[^<]*</td></tr>", "</tr>", table[0]), text)
    if file.name == "junit.xml":
        return re.sub(r' time="[^"]*"', "", file.read_text())
    if SEALED.fullmatch(file.name):
        table = json.loads(file.read_text())
        return sorted(table), {key: value for key, value in table.items() if key not in SALTED}
    return logged(file) if file.suffix == ".rrd" else file.read_bytes()


def timeless(value: Any) -> Any:
    """Return JSON with its run times taken out."""
    if isinstance(value, dict):
        timed = ("seconds", "value") if value.get("name") == "seconds" else ("seconds",)
        return {key: None if key in timed else timeless(inner) for key, inner in value.items()}
    return [timeless(inner) for inner in value] if isinstance(value, list) else value


def logged(file: Path) -> dict[str, object]:
    """Return what tells the values in a .rrd file from others, by entity and column, in the order of their rows.

    Left out are the numbers that Rerun gives to rows, chunks and the layout's nodes anew in each run, the time of day,
    and how rows are spread over chunks, which depends on a timer. The nodes of the layout are put in order.
    """
    from rerun.chunk import RrdReader

    reader = RrdReader(file)
    columns: dict[str, list[tuple[pa.Array, pa.Array]]] = {}
    for store in (*reader.recordings(), *reader.blueprints()):
        for chunk in reader.stream(store=store):
            batch = chunk.to_record_batch()
            for name in batch.schema.names:
                if name not in (ROW, *DRAWN):
                    key = UUID.sub("ID", f"{store.kind} {chunk.entity_path} {name}")
                    columns.setdefault(key, []).append((batch.column(ROW), batch.column(name)))
    return {key: _layout(parts) if key.startswith("blueprint") else _values(parts) for key, parts in columns.items()}


def _layout(parts: list[tuple[pa.Array, pa.Array]]) -> list[str]:
    return sorted(UUID.sub("ID", repr(value)) for _, column in parts for value in column.to_pylist())


def _values(parts: list[tuple[pa.Array, pa.Array]]) -> str:
    rows, values = (pa.concat_arrays([_stored(part[side]) for part in parts]) for side in (0, 1))
    numbers = np.frombuffer(b"".join(rows.to_pylist()), dtype=">u8").reshape(-1, 2)
    ordered = values.take(pa.array(np.lexsort(numbers.T[::-1])))
    return hashlib.sha256(pa.record_batch([ordered], ["x"]).serialize()).hexdigest()


def _stored(array: pa.Array) -> pa.Array:
    return array.storage if isinstance(array, pa.ExtensionArray) else array


def without_stages(said: str) -> str:
    """Return what a command said on stderr, but for the lines by which it tells how far it is."""
    return STAGE.sub("", said)
