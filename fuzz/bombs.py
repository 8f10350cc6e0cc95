"""Inputs too large to be kept, made by code: small files that are gigabytes in memory, tables of millions of rows."""

from collections.abc import Callable

from fuzz.mutate import csv, hdf5, json, mat, mjcf, nasty, parquet, toml

Bomb = Callable[[bytes], bytes]
"""Takes a valid content and returns the bomb."""


def _parts(content: bytes) -> tuple[bytes, bytes, bytes]:
    """Return the lines above the header of a CSV, the header, and its rows."""
    lines = content.splitlines(keepends=True)
    first = next(k for k, line in enumerate(lines) if not line.startswith(b"#"))
    return b"".join(lines[:first]), lines[first].rstrip(b"\n"), b"".join(lines[first + 1 :])


def many_rows(content: bytes) -> bytes:
    """Return a CSV of two million rows, or 40 MB, whose last line is broken."""
    above, header, _ = _parts(content)
    return above + csv.many(header.decode(), header.count(b",") + 1)


def long_header(content: bytes) -> bytes:
    """Return a CSV with a name in its header that Python's csv module does not take."""
    above, header, rows = _parts(content)
    return above + header + b"," + b"x" * nasty.CELL + b"\n" + rows


def long_cell(content: bytes) -> bytes:
    """Return a CSV whose last row has such a cell."""
    return content + b'"' + b"x" * nasty.CELL + b'"\n'


def deep_toml(content: bytes) -> bytes:
    """Return TOML nested 3,000 deep."""
    return content + f"\nx = {'[' * nasty.DEEP}{']' * nasty.DEEP}\n".encode()


def long_number_toml(content: bytes) -> bytes:
    """Return TOML with a number of 5,000 digits."""
    return b"x = " + b"9" * nasty.DIGITS + b"\n" + content


def deep_json(content: bytes) -> bytes:
    """Return JSON nested 200,000 deep."""
    return b"[" * 200_000 + b"]" * 200_000


def long_number_json(content: bytes) -> bytes:
    """Return JSON that is a number of 5,000 digits."""
    return b'{"x": ' + b"9" * nasty.DIGITS + b"}"


def many_rows_parquet(content: bytes) -> bytes:
    """Return a Parquet file of some hundred kB that says one row millions of times."""
    return parquet.many(content)


def huge_dataset(content: bytes) -> bytes:
    """Return an HDF5 file whose dataset has 10^12 rows that nobody wrote."""
    return hdf5.huge(content, "imu_gyr", (2**40, 3))


def compressed_zeros(content: bytes) -> bytes:
    """Return a .mat file of 2 MB whose first element is 2 GB of zeros, compressed."""
    return mat.zeros(content, 2_000_000_000)


def replicated(content: bytes) -> bytes:
    """Return MJCF of a few lines that asks for three million bodies."""
    return content.replace(b"<worldbody>", b'<worldbody><replicate count="3000000"><geom size=".1"/></replicate>', 1)


def nested_bodies(content: bytes) -> bytes:
    """Return MJCF with bodies nested 3,000 deep."""
    return content.replace(b"<worldbody>", b"<worldbody>" + mjcf.nested(nasty.DEEP), 1)


BOMBS: dict[object, tuple[Bomb, ...]] = {
    csv.mutate: (many_rows, long_header, long_cell),
    csv.mutate_diodem: (many_rows, long_header, long_cell),
    toml.mutate: (deep_toml, long_number_toml),
    json.mutate: (deep_json, long_number_json),
    parquet.mutate: (many_rows_parquet,),
    hdf5.mutate: (huge_dataset,),
    mat.mutate: (compressed_zeros,),
    mjcf.mutate: (replicated, nested_bodies),
}
"""The bombs of each format, by its mutator."""
