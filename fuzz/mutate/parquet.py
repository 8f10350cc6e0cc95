"""Parquet: columns of other types, shapes and counts, written by Arrow; then pages and footer damaged."""

from decimal import Decimal
from functools import lru_cache
from io import BytesIO
from random import Random

import pyarrow as pa
import pyarrow.parquet as pq

from fuzz.mutate import bytes as plain
from fuzz.mutate import nasty

MANY = 140_000_000  # numbers that run-length encoding holds in a small file: 20 million rows of an IMU
GROUPS = 10
MILD = 0.35  # of the tables have other numbers alone: what follows reading is tried too
FACTORS = (0.0, -1.0, 1e-9, 1e-3, 0.5, 2.0, 57.3, 1e3, 1e6, 1e12)
CODECS = ("none", "snappy", "gzip", "zstd", "lz4")
LARGE = 5_000  # numbers beyond which a table is not written in tiny pieces


def mutate(content: bytes, rng: Random) -> bytes:
    """Return a Parquet file with changed columns, rows, layout or bytes."""
    kind = rng.random()
    if kind < 0.2:
        return plain.mutate(content, rng)
    if kind < 0.35:
        return _footer(content, rng)
    try:
        table = pq.read_table(BytesIO(content))
        if kind < 0.353:
            return many(content)
        if rng.random() < MILD:
            table = _numbers(table, rng)
        else:
            for _ in range(1 + min(int(rng.expovariate(1.0)), 3)):
                table = _change(table, rng)
        out = written(table, rng)
    except (pa.ArrowException, OSError, ValueError, TypeError, OverflowError):  # a type that this file cannot hold
        return plain.mutate(content, rng)
    return _footer(out, rng) if rng.random() < 0.1 else out


def written(table: pa.Table, rng: Random) -> bytes:
    """Return a table in one of the layouts that Parquet has."""
    out = BytesIO()
    pq.write_table(
        table,
        out,
        compression=rng.choice(CODECS),
        version=rng.choice(("1.0", "2.4", "2.6")),
        use_dictionary=rng.random() < 0.5,
        data_page_version=rng.choice(("1.0", "2.0")),
        row_group_size=rng.choice((1_000, 1_000_000) if table.num_rows * table.num_columns > LARGE else (1, 7, 50)),
        write_statistics=rng.random() < 0.5,
        store_schema=rng.random() < 0.7,
    )
    return out.getvalue()


@lru_cache(maxsize=16)
def many(content: bytes) -> bytes:
    """Return a file with the columns of another whose first row comes so often that it is gigabytes in memory."""
    first = pq.read_table(BytesIO(content)).slice(0, 1)
    rows = MANY // GROUPS // first.num_columns
    group = pa.table(
        {name: pa.repeat(first[name][0], rows) for name in dict.fromkeys(first.column_names)},
        schema=first.schema,
    )
    out = BytesIO()
    with pq.ParquetWriter(out, group.schema, compression="zstd", use_dictionary=True) as writer:
        for _ in range(GROUPS):
            writer.write_table(group)
    return out.getvalue()


def _footer(content: bytes, rng: Random) -> bytes:
    """Return a file whose footer, which holds counts, offsets and types, is damaged."""
    size = int.from_bytes(content[-8:-4], "little")
    start = len(content) - 8 - size
    if start < 4:
        return plain.mutate(content, rng)
    if rng.random() < 0.2:
        wrong = rng.choice((0, 1, size - 1, size + 1, 0x7FFFFFFF, 0xFFFFFFFF))
        return content[:-8] + (wrong % 2**32).to_bytes(4, "little") + content[-4:]
    footer = plain.flip(content[start:-8], rng) if rng.random() < 0.7 else plain.mutate(content[start:-8], rng)
    return content[:start] + footer + (len(footer) % 2**32).to_bytes(4, "little") + content[-4:]


def _change(table: pa.Table, rng: Random) -> pa.Table:
    kind, n = rng.randrange(12), table.num_rows
    if not table.num_columns:
        return table
    c = rng.randrange(table.num_columns)
    name, column = table.column_names[c], table.column(c)
    if kind == 0:
        return table.remove_column(c)
    if kind == 1:
        names = list(table.column_names)
        names[c] = nasty.text(rng) if rng.random() < 0.5 else rng.choice(names)
        return table.rename_columns(names)
    if kind == 2:
        return table.append_column(rng.choice((name, "extra", nasty.text(rng))), column)
    if kind == 3:
        return table.slice(0, rng.choice((0, 1, 2, 3, 5)))
    if kind == 4:
        return table.take(pa.array(range(n - 1, -1, -1)))
    if kind == 5 and n * table.num_columns <= LARGE:
        return pa.concat_tables([table] * rng.choice((2, 3, 50)))
    if kind == 6:
        return table.set_column(c, name, column.combine_chunks().dictionary_encode())
    if kind == 7 and n:
        return table.set_column(c, name, _with_cell(column, rng))
    return table.set_column(c, name, _column(n, column, rng))


def _numbers(table: pa.Table, rng: Random) -> pa.Table:
    """Return a table with other numbers in some of its columns, or fewer rows: one that may well be accepted."""
    if rng.random() < 0.2:
        return table.slice(rng.randrange(max(table.num_rows, 1)), rng.choice((1, 2, 5, 20, 60)))
    floating = [c for c, column in enumerate(table.columns) if pa.types.is_floating(column.type)]
    factor, offset, held = rng.choice(FACTORS), rng.choice((0.0, 0.0, 1.0, -5.0, 1e6)), rng.random() < 0.3
    for c in rng.sample(floating, min(len(floating), rng.choice((1, 3, len(floating))))):
        values = [None if v is None else v * factor + offset for v in table.column(c).to_pylist()]
        values = [values[0]] * len(values) if held and values else values
        table = table.set_column(c, table.column_names[c], pa.array(values, type=table.column(c).type))
    return table


def _with_cell(column: pa.ChunkedArray, rng: Random) -> pa.Array:
    values = column.to_pylist()
    for _ in range(rng.choice((1, 1, 5))):
        values[rng.randrange(len(values))] = rng.choice(
            (None, float("nan"), float("inf"), -1.0, 0.0, 1e300, rng.choice(values))
        )
    return pa.array(values, type=column.type, from_pandas=False)


def _column(n: int, column: pa.ChunkedArray, rng: Random) -> pa.Array:
    """Return n values of a type that may not belong there."""
    row = list(range(n))
    makers = (
        lambda: pa.array([str(i) for i in row]),
        lambda: pa.array([nasty.text(rng).encode("utf-8", "replace").decode() for _ in row]),
        lambda: pa.array([b"\xff\x00"] * n, type=pa.binary()),
        lambda: pa.array([[1.0, 2.0]] * n, type=pa.list_(pa.float64())),
        lambda: pa.array([[]] * n, type=pa.list_(pa.float64())),
        lambda: pa.array([{"a": 1.0, "b": "x"}] * n),
        lambda: pa.array([Decimal(i) / 4 for i in row], type=pa.decimal128(30, 6)),
        lambda: pa.array([Decimal(10) ** 60] * n, type=pa.decimal256(70, 6)),
        lambda: pa.nulls(n),
        lambda: pa.array([None] * n, type=pa.float64()),
        lambda: pa.array([i % 2 == 0 for i in row]),
        lambda: pa.array(row, type=pa.int8()) if n < 128 else pa.array(row, type=pa.int32()),
        lambda: pa.array([2**63 - 1] * n, type=pa.int64()),
        lambda: pa.array(row, type=pa.timestamp("ns")),
        lambda: pa.array(row, type=pa.date32()),
        lambda: pa.array(row, type=pa.duration("us")),
        lambda: pa.array([float(i) for i in row], type=pa.float32()),
        lambda: pa.array([float(i) for i in row]).cast(pa.float16()) if hasattr(pa, "float16") else pa.nulls(n),
        lambda: pa.array([float(nasty.number(rng)) for _ in row]),
        lambda: pa.array([json_like(rng) for _ in row]),
        lambda: pa.array(column.to_pylist()[::-1]),
        lambda: pa.array([[[["deep"]]]] * n),
        lambda: pa.array([{}] * n, type=pa.map_(pa.string(), pa.int64())),
    )
    return rng.choice(makers)()


def json_like(rng: Random) -> str:
    """Return text that a reader may take for JSON: some columns of a dataset hold it."""
    return rng.choice(
        ("", "{}", "[]", "null", "NaN", "{", '{"bias": 1}', '{"bias": "x"}', "9" * nasty.DIGITS, "[" * 5_000)
    )
