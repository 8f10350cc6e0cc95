"""Time stamps of a table whose unit its owner says, or not: which unit they can be in, and no digit of them lost."""

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from pathlib import Path

import numpy as np

from imubench.arrays import Array
from imubench.convert.table import read_lines
from imubench.errors import InputError
from imubench.format1.physics_checks import FASTEST_RATE, LATEST, SLOWEST_RATE, usual_factor

TIME_UNITS = {"s": "1", "ms": "1e-3", "us": "1e-6", "ns": "1e-9"}  # as exact decimal fractions of a second
SLOWEST_GUESS = (
    1.0  # Hz; at this rate or below the unit has to be said: milliseconds at 1 kHz look like seconds at 1 Hz
)
ROUNDING = 1e-6  # of a step, that the rounding of stamps may make
MOST_BYTES = 256 * 2**20  # of a file whose stamps are read a second time, digit by digit


@dataclass(frozen=True)
class Stamps:
    """The column of time stamps of one file, as 64-bit numbers."""

    path: Path
    column: str
    values: Array  # (n,) in the file's unit


def in_seconds(files: Sequence[Stamps], unit: str) -> tuple[list[Array], str]:
    """Return the stamps of each file, all on one clock, in s, and a note where that clock's zero was moved; else "".

    `unit` "" stands for s, where nobody has said so: stamps are then asked to be over `SLOWEST_GUESS`. Stamps that are
    so large that 64-bit numbers in s would round their steps, as those since 1970 are, count from the whole second
    before the first one. Raises `InputError` with the unit that the stamps are probably in.
    """
    for stamps in files:
        _check_unit(stamps, unit)
    factor = TIME_UNITS[unit or "s"]
    if not any(_rounded(stamps, float(factor)) for stamps in files):
        return [stamps.values * float(factor) for stamps in files], ""
    zero = int(np.floor(min(stamps.values[0] for stamps in files) * float(factor)))
    return [_since(stamps, factor, zero) for stamps in files], (
        f"The clock's zero was moved by {zero} s: stamps as large as in the file would be rounded to "
        f"{np.spacing(float(abs(zero))):.1g} s. "
    )


def _check_unit(stamps: Stamps, unit: str) -> None:
    values, said = stamps.values, f"time_unit '{unit}'" if unit else "seconds, as no time_unit is said"
    where = f"{stamps.path}, column '{stamps.column}'"
    factor = float(TIME_UNITS[unit or "s"])
    late = float(np.abs(values).max(initial=0.0))
    if late * factor > LATEST:
        likely = [name for name, text in TIME_UNITS.items() if 1e9 <= late * float(text) <= LATEST / 2]
        guess = f": probably time_unit={likely[0]}, since 1970" if likely else ""
        raise InputError(f"{where}: expected stamps up to {LATEST:g} s, got {late:.6g} in {said}{guess}")
    if values.size < 3:
        return
    step = float(np.median(np.diff(values)))
    if step <= 0:
        return  # said with its row when the recording is made
    rate = 1.0 / (step * factor)
    slow = rate < SLOWEST_RATE if unit else rate <= SLOWEST_GUESS
    if not slow and rate <= FASTEST_RATE:
        return
    usual = usual_factor(step, {name: float(text) for name, text in TIME_UNITS.items() if name != (unit or "s")})
    guess = f": probably time_unit={usual}" if usual else f"; known: {', '.join(TIME_UNITS)}"
    raise InputError(
        f"{where}: expected over {SLOWEST_RATE if unit else SLOWEST_GUESS:g} and up to {FASTEST_RATE:g} samples a "
        f"second, got {rate:.3g} from median steps of {step:.6g} in {said}{guess}"
    )


def _rounded(stamps: Stamps, factor: float) -> bool:
    """Tell whether stamps in s are so large that as 64-bit numbers their steps are rounded by over `ROUNDING`."""
    if stamps.values.size < 2:
        return False
    step = float(np.median(np.diff(stamps.values)))
    return bool(np.spacing(float(np.abs(stamps.values).max())) > ROUNDING * step > 0)


def _since(stamps: Stamps, factor: str, zero: int) -> Array:
    """Return stamps in s since `zero`, from the digits in the file where these can be had, else from 64-bit numbers."""
    texts = _texts(stamps)
    if texts is None:
        return np.asarray(stamps.values * float(factor) - zero)
    unit = Decimal(factor)
    return np.array([float(Decimal(text) * unit - zero) for text in texts])


def _texts(stamps: Stamps) -> list[str] | None:
    """Return the stamps as they stand in the file; None where they are not simply one a line."""
    count = stamps.values.size
    if stamps.path.stat().st_size > MOST_BYTES:
        return None
    try:
        header, *rows = csv.reader(read_lines(stamps.path, 1 + count))
        place = [name.strip() for name in header].index(stamps.column)
        texts = [row[place].strip() for row in rows]
        same = len(texts) == count and all(float(Decimal(t)) == v for t, v in zip(texts, stamps.values, strict=True))
    except (ValueError, IndexError, InvalidOperation, InputError, csv.Error):
        return None  # a line of another kind among them: the table's reader has judged it
    return texts if same else None
