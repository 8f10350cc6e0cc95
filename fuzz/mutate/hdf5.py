"""HDF5: datasets and attributes missing, odd, huge or linked elsewhere, written by h5py; then bytes damaged."""

from io import BytesIO
from random import Random
from typing import Any

import h5py
import numpy as np

from fuzz.mutate import bytes as plain
from fuzz.mutate import nasty


def mutate(content: bytes, rng: Random) -> bytes:
    """Return an HDF5 file with changed objects, links, attributes or bytes."""
    if rng.random() < 0.3:
        return plain.mutate(content, rng)
    out = BytesIO(content)
    try:
        with h5py.File(out, "r+") as file:
            for _ in range(1 + min(int(rng.expovariate(1.0)), 3)):
                _change(file, rng)
    except (OSError, ValueError, TypeError, RuntimeError, LookupError, OverflowError):  # what this file cannot hold
        return plain.mutate(content, rng)
    return plain.mutate(out.getvalue(), rng) if rng.random() < 0.1 else out.getvalue()


def _change(file: h5py.File, rng: Random) -> None:
    kind = rng.randrange(6)
    if kind == 0:
        key = rng.choice(list(file.attrs) or ["sampling_rate"])
        if key in file.attrs:
            del file.attrs[key]
        if rng.random() < 0.8:
            file.attrs[key] = _attribute(rng)
        return
    name = rng.choice(list(file))
    if kind == 1:
        file.move(name, f"other{rng.randrange(100)}")
        return
    old = file[name] if file.get(name, getlink=True).__class__ is h5py.HardLink else None
    shape = old.shape if isinstance(old, h5py.Dataset) and old.shape is not None else (10, 3)
    del file[name]
    if kind == 2:
        _link(file, name, rng)
    elif kind == 3:
        rows = rng.choice((200_000_000, 2**40, 2_000_000))
        _unwritten(file, name, (rows, *rng.choice(((3,), (4,), (), (3, 1_000)))))
    elif kind == 4:
        file.create_group(name)["inner"] = np.zeros(3)
    else:
        _odd(file, name, shape, rng)


def _attribute(rng: Random) -> Any:
    return rng.choice(
        (
            "fast", "200", b"\xff", 0.0, -200.0, float("nan"), float("inf"), 1e300, 1e-300, np.zeros(0), np.ones(3),
            np.array([[200.0]]), 200, True, 1 + 2j, h5py.Empty("f"), np.array([200], dtype=">i2"), "\x1b[31m",
        )
    )  # fmt: skip


def _link(file: h5py.File, name: str, rng: Random) -> None:
    """Put a link in an object's place: to nothing, to itself, to a file outside, to its raw bytes."""
    kind = rng.randrange(6)
    if kind == 0:
        file[name] = h5py.SoftLink("/nothing")
    elif kind == 1:
        file[name] = h5py.SoftLink(f"/{name}")
    elif kind == 2:
        file[name] = h5py.ExternalLink(f"{nasty.OUTSIDE}/kept.hdf5", "/imu_gyr")
    elif kind == 3:
        file[name] = h5py.ExternalLink("../outside/kept.hdf5", "/imu_gyr")
    elif kind == 4:
        raw = [(f"{nasty.OUTSIDE}/kept.csv", 0, 48)]
        file.create_dataset(name, (2, 3), dtype="f8", external=raw)
    else:
        space = h5py.h5s.create_simple((10, 3))
        how = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
        how.set_obj_track_times(False)  # which `create_virtual_dataset` does: the same bytes whenever it is made
        how.set_virtual(space, f"{nasty.OUTSIDE}/kept.hdf5".encode(), b"imu_gyr", space)
        h5py.h5d.create(file.id, name.encode(), h5py.h5t.IEEE_F64LE, space, how)


def huge(content: bytes, name: str, shape: tuple[int, ...]) -> bytes:
    """Return a file in which a dataset has a shape, and no chunk of it was written."""
    out = BytesIO(content)
    with h5py.File(out, "r+") as file:
        del file[name]
        _unwritten(file, name, shape)
    return out.getvalue()


def _unwritten(file: h5py.File, name: str, shape: tuple[int, ...]) -> None:
    """Put a dataset in place that is a few kB on the disk and gigabytes in memory."""
    file.create_dataset(name, shape, dtype="f8", chunks=(4_096, *shape[1:]), compression="gzip", fillvalue=1.0)


def _odd(file: h5py.File, name: str, shape: tuple[int, ...], rng: Random) -> None:
    n = min(shape[0], 1_000) if shape else 1  # another change may have made it huge
    value: Any = rng.choice(
        (
            0.0, "text", np.zeros(0), np.zeros((0, 3)), np.zeros((n, 3), dtype=complex), np.zeros((n, 3), dtype="i1"),
            np.zeros((n, 3), dtype=bool), np.full((n, 3), np.nan), np.full((n, 3), np.inf), np.full((n, 3), 1e308),
            np.zeros((n, 4)), np.zeros((n, 3, 1)), np.zeros((3, n)), np.zeros((n + 1, 3)), np.zeros((max(n - 1, 0), 3)),
            np.zeros((1, 3)), np.zeros((2, 3)), np.zeros(n, dtype=[("x", "f8"), ("y", "S3")]), h5py.Empty("f8"),
            np.array([b"abc"] * n), np.zeros((n, 3), dtype=">f4"), np.zeros((n, 3), dtype=np.float16),
        )
    )  # fmt: skip
    kind = rng.randrange(6)
    if kind == 0:
        rows = file.create_dataset(name, (n,), dtype=h5py.vlen_dtype(np.float64))
        rows[0] = np.ones(3)
    elif kind == 1:
        file.create_dataset(name, (n, 3), dtype=h5py.string_dtype(), data=np.full((n, 3), "1.5", dtype=object))
    elif kind == 2:
        file.create_dataset(name, (n,), dtype=h5py.ref_dtype)
    elif kind == 3:
        file.create_dataset(name, (n, 3), dtype=h5py.enum_dtype({"A": 0, "B": 1}, basetype="i"))
    else:
        file[name] = value
