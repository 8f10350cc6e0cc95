"""HDF5 files: arrays of numbers by name, their sizes known before they are read, and no link followed elsewhere."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import prod
from pathlib import Path
from typing import Any

import numpy as np

from imubench.arrays import Array
from imubench.errors import InputError, first_line, shown
from imubench.inputs.files import opened
from imubench.inputs.limits import BINARY_BYTES, NUMBERS, SIZE
from imubench.inputs.tables import listed


@dataclass(frozen=True)
class Hdf5:
    """What was read of a file."""

    arrays: Mapping[str, Array]
    attributes: Mapping[str, float]


def read_hdf5(
    path: Path, required: Sequence[str], optional: Sequence[str] = (), attributes: Sequence[str] = ()
) -> Hdf5:
    """Return datasets of numbers and attributes that hold one number.

    Args:
        path: the file.
        required: datasets that must be there.
        optional: datasets that are read where they are there.
        attributes: of the file itself, each a number, which must be there.

    Raises:
        InputError: h5py is not installed; no HDF5, damaged, something is missing, holds no numbers, leads to another
            file, or is beyond the limits.
    """
    try:
        import h5py
    except ImportError:
        raise InputError(f"{path}: expected h5py to read HDF5, got none; pip install 'imubench[convert]'") from None
    with opened(path, BINARY_BYTES) as raw:
        try:
            with h5py.File(raw, "r") as file:
                names = [*required, *(name for name in optional if name in file)]
                budget = NUMBERS
                arrays = {}
                for name in names:
                    dataset = _dataset(path, h5py, file, name, budget)
                    budget -= prod(dataset.shape)
                    arrays[name] = np.asarray(dataset[()], dtype=float)
                    if (np.abs(arrays[name][np.isfinite(arrays[name])]) > SIZE).any():
                        raise InputError(f"{path}, key '{name}': expected numbers of at most {SIZE:g}, got larger ones")
                return Hdf5(arrays, {name: _attribute(path, file, name) for name in attributes})
        except InputError:
            raise
        except Exception as error:  # the library's own errors for damaged files are of every kind
            reason = first_line(error)
            raise InputError(f"{path}: expected a readable HDF5 file, got: {reason}") from None


def _dataset(path: Path, h5py: Any, file: Any, name: str, most: int) -> Any:
    if name not in file:
        raise InputError(f"{path}: expected key '{name}', got {listed([str(k) for k in file]) or 'none'}")
    if not isinstance(file.get(name, getlink=True), h5py.HardLink):
        raise InputError(f"{path}, key '{name}': expected the numbers themselves, got a link")
    dataset = file[name]
    if not isinstance(dataset, h5py.Dataset) or dataset.dtype.kind not in "fiub" or dataset.shape is None:
        raise InputError(f"{path}, key '{name}': expected numbers, got {shown(dataset)}")
    if dataset.is_virtual or dataset.external:
        raise InputError(f"{path}, key '{name}': expected the numbers themselves, got those of another file")
    if prod(dataset.shape) > most:
        raise InputError(
            f"{path}, key '{name}': expected at most {NUMBERS:,} numbers in the file, got shape {dataset.shape}"
        )
    return dataset


def _attribute(path: Path, file: Any, name: str) -> float:
    if name not in file.attrs:
        raise InputError(f"{path}: expected attribute '{name}', got {listed([str(k) for k in file.attrs]) or 'none'}")
    value = np.asarray(file.attrs[name])
    if value.dtype.kind not in "fiu" or value.size != 1 or not np.isfinite(value).all():
        raise InputError(f"{path}, attribute '{name}': expected a number, got {shown(value.tolist())}")
    return float(value.ravel()[0])
