"""README.md: a dataset's card for people, with the head that the Hugging Face hub and its `datasets` read."""

import json
from collections.abc import Iterator, Mapping
from typing import Any

import pyarrow as pa

from imubench.dataset import columns, rows
from imubench.dataset.card import limits
from imubench.dataset.published.columns import told
from imubench.dataset.published.tables import TABLES, Part, parts
from imubench.dataset.published.terms import SPDX, cited
from imubench.dataset.published.text import described, made_with
from imubench.dataset.spec import SPEC_FILE, Spec

README = "README.md"
TAGS = ("imu", "inertial-sensors", "motion-capture", "simulation", "time-series")
SIZES = ("1K", "10K", "100K", "1M", "10M", "100M", "1B", "10B", "100B", "1T")
READ = """\
```python
import datasets

datasets.load_dataset("DIR")                         # {splits}: the table of samples
datasets.load_dataset("DIR", "recordings")           # what was drawn for each recording
datasets.load_dataset("DIR", streaming=True)         # without a copy on the disk

from imubench.dataset import read                    # one recording with its truth

stored = read("DIR", {index})
```

`DIR` is the folder of this file. `imubench diagnose DIR#{index}` takes recording {index} as it is, and any reader of
Parquet takes the files."""


def readme(spec: Spec, manifest: Mapping[str, Any]) -> str:
    """Return the card of a dataset in Markdown, its head in YAML."""
    there = {table: parts(manifest, table) for table in TABLES}
    schemas = {"samples": columns.schema(spec), "recordings": rows.schema(spec)}
    lines = ["---", *_head(spec, there, schemas), "---", ""]
    lines += [f"# {_plain(spec.name)}", "", _plain(described(spec, manifest))]
    lines += ["", "## Splits", "", "All recordings of a rig are in one split.", "", *_splits(there)]
    read = READ.format(splits=", ".join(there["samples"]), index=manifest["count"] - 1)
    lines += ["", "## Reading", "", read]
    lines += ["", "## Columns", "", "SI units and radians; vectors are x, y, z, quaternions w, x, y, z; world is z up."]
    lines += ["What a rig does not have is empty."]
    for table, schema in schemas.items():
        lines += ["", f"### {table}", "", "| column | type | unit | what |", "|---|---|---|---|", *_table(schema)]
    lines += ["", "## Limits", "", *(f"- {_plain(limit)}" for limit in limits(spec))]
    lines += ["", "## Licence", "", _plain(spec.terms.licence) or "None stated."]
    lines += ["", "## How to make it again", "", *_again(manifest)]
    lines += ["", "## Citation", "", "```bibtex", cited(spec.name, spec.terms, made_with(manifest)), "```"]
    return "\n".join(lines) + "\n"


def _splits(there: Mapping[str, Mapping[str, Part]]) -> Iterator[str]:
    yield "| split | recordings | rows of samples |"
    yield "|---|---|---|"
    for split, part in there["samples"].items():
        yield f"| {split} | {there['recordings'][split].rows:,} | {part.rows:,} |"


def _again(manifest: Mapping[str, Any]) -> Iterator[str]:
    yield "```sh"
    yield f"imubench generate spec/{SPEC_FILE} --count {manifest['count']} --seed {manifest['seed']} --out AGAIN"
    yield "```"
    yield ""
    versions = ", ".join(f"{name} {version}" for name, version in manifest["versions"].items())
    yield f"With {versions} on {_plain(manifest['machine'])}: the same bytes."


def _head(spec: Spec, there: Mapping[str, Mapping[str, Part]], schemas: Mapping[str, pa.Schema]) -> Iterator[str]:
    """Yield the lines of YAML; each value is JSON, which YAML takes as it is."""
    yield f"pretty_name: {_json(spec.name)}"
    yield from _licence(spec)
    yield f"tags: {_json(TAGS)}"
    total = sum(part.rows for part in there["samples"].values())
    yield f"size_categories: {_json([_size(total)])}"
    yield "configs:"
    for table in TABLES:
        yield f"- config_name: {table}"
        if table == "samples":
            yield "  default: true"
        yield "  data_files:"
        yield from (f"  - {_json({'split': s, 'path': f'{table}/{s}-*.parquet'})}" for s in there[table])
    yield "dataset_info:"
    for table in TABLES:
        yield f"- config_name: {table}"
        yield "  features:"
        yield from (f"  - {_json({'name': field.name, **_feature(field.type)})}" for field in schemas[table])


def _size(count: int) -> str:
    """Return the hub's name for so many rows."""
    over = len(str(count)) - 4  # of 1,000 it is 0
    if over < 0:
        return f"n<{SIZES[0]}"
    return f"{SIZES[over]}<n<{SIZES[over + 1]}" if over + 1 < len(SIZES) else f"n>{SIZES[-1]}"


def _licence(spec: Spec) -> Iterator[str]:
    if not spec.terms.licence:
        yield "license: unknown"
    elif spec.terms.spdx:
        yield f"license: {SPDX[spec.terms.spdx]}"
    else:
        yield "license: other"
        yield f"license_name: {_json(spec.terms.licence)}"


def _feature(kind: pa.DataType) -> dict[str, Any]:
    """Return a column's type as `datasets` writes it."""
    if pa.types.is_fixed_size_list(kind):
        return {"list": _dtype(kind.value_type), "length": kind.list_size}
    if pa.types.is_list(kind):
        return {"list": [{"name": part.name, "dtype": _dtype(part.type)} for part in kind.value_type]}
    return {"dtype": _dtype(kind)}


def _dtype(kind: pa.DataType) -> str:
    named = {pa.float32(): "float32", pa.float64(): "float64"}
    return named.get(kind, "string" if pa.types.is_dictionary(kind) else str(kind))


def _table(schema: pa.Schema) -> Iterator[str]:
    """Yield a row for each column, components of one vector together."""
    vectors: dict[str, list[str]] = {}
    for field in schema:
        stem, _, last = field.name.rpartition("_")
        whole = stem if last in ("w", "x", "y", "z") else field.name
        vectors.setdefault(whole, []).append(last if whole == stem else "")
    for whole, components in vectors.items():
        first = whole + f"_{components[0]}" * bool(components[0])
        kind = schema.field(first).type
        shown = f"{whole}_{components[0]}..{components[-1]}" if components[0] else whole
        said = told(first)
        yield f"| `{shown}` | {_shown(kind)} | {said.unit} | {said.meaning} |"


def _shown(kind: pa.DataType) -> str:
    if pa.types.is_fixed_size_list(kind):
        return f"{_dtype(kind.value_type)} ({kind.list_size})"
    return "list" if pa.types.is_list(kind) else _dtype(kind)


def _json(value: object) -> str:
    return json.dumps(value, ensure_ascii=False)


def _plain(text: str) -> str:
    """Return text that Markdown shows as it is."""
    return "".join(f"\\{c}" if c in "\\`*_[]<>#|" else c for c in text)
