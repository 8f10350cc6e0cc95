"""The spec of a sweep: that of a dataset, with axes, how many recordings a cell has, a figure and its limit."""

from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import product
from pathlib import Path
from typing import Any

import tomli_w

from imubench.dataset.ranges import check_keys, number
from imubench.dataset.spec import KEYS as DATASET_KEYS
from imubench.dataset.spec import SPEC_FILE, Spec, beside, parse_spec
from imubench.errors import InputError, shown
from imubench.inputs.files import read_bytes
from imubench.inputs.toml import parse_toml
from imubench.sweeps.axis import Axis, parse_axis

SWEEP_FILE = "sweep.toml"
OWN = ("axis", "recordings", "figure", "quantile", "limit_deg", "limit_mm")
STORAGE = (
    "licence",
    "recordings_per_file",
    "precision",
    "truth",
    "splits",
)  # of a dataset's files, which are not written
RECORDINGS = 20  # a cell: the 6th and the 15th are the ends of the median's interval
MOST_RECORDINGS = 10_000  # a cell
MOST_CELLS = 2_500  # 50 x 50: checked in some ten seconds, and still told apart on a page
UNITS = {"limit_deg": ("deg", "rad"), "limit_mm": ("mm", "m")}  # key -> shown unit, unit of the score


@dataclass(frozen=True)
class Sweep:
    """A sweep, checked: every cell's spec is one."""

    name: str
    summary: str
    axes: tuple[Axis, ...]  # one or two
    recordings: int  # of a cell
    figure: str | None  # of a score, without its IMU's name: the largest of the IMUs; None: the quantity's own
    quantile: float  # of a cell's recordings that the map shows
    limit: float  # in `unit`
    unit: str  # deg or mm
    content: Mapping[str, bytes] = field(repr=False)  # the file and those it names

    @property
    def shape(self) -> tuple[int, int]:
        """How many values each axis has; the second is 1 where there is none."""
        return len(self.axes[0].values), len(self.axes[1].values) if len(self.axes) > 1 else 1

    @property
    def score_unit(self) -> str:
        """The unit of a score's figure that the limit is for."""
        return dict(UNITS.values())[self.unit]

    def cell_toml(self, i: int, j: int = 0) -> bytes:
        """Return the dataset's spec of a cell as a file, as `imubench generate` takes it."""
        return _cell_toml(self.content[SWEEP_FILE], self.axes, i, j)

    def cell(self, i: int, j: int = 0) -> Spec:
        """Return the dataset's spec of a cell; `InputError` where its numbers make none."""
        others = {name: file for name, file in self.content.items() if name != SWEEP_FILE}
        at = ", ".join(a.shown(a.values[k]) for a, k in zip(self.axes, (i, j), strict=False))
        return _cell(tuple(sorted((others | {SPEC_FILE: self.cell_toml(i, j)}).items())), f"{SWEEP_FILE}, cell at {at}")


def load_sweep(path: Path, recordings: int | None = None) -> Sweep:
    """Return the sweep in a TOML file, every cell checked; `recordings` a cell replaces the file's."""
    content = {SWEEP_FILE: read_bytes(path)}
    return parse_sweep(content, str(path), recordings, path)


def parse_sweep(
    content: Mapping[str, bytes],
    where: str = SWEEP_FILE,
    recordings: int | None = None,
    path: Path | None = None,
    every_cell: bool = True,
) -> Sweep:
    """Return the sweep in `content["sweep.toml"]`.

    Args:
        content: the file, and those that it names.
        where: its name, for messages.
        recordings: a cell, instead of the file's.
        path: of the file, where those that it names are beside it and not in `content`.
        every_cell: whether each cell is checked to be a spec, and not the first alone.

    Raises:
        InputError: an unknown key, axes that are none, a parameter that the spec has not, a cell that is no spec.
    """
    table = parse_toml(content[SWEEP_FILE], where)
    check_keys(table, (*(key for key in DATASET_KEYS if key not in STORAGE), *OWN), where)
    axes = _axes(table, where)
    unit, limit = _limit(table, where)
    count = table.get("recordings", RECORDINGS) if recordings is None else recordings
    if not isinstance(count, int) or isinstance(count, bool) or not 1 <= count <= MOST_RECORDINGS:
        raise InputError(
            f"{where}: recordings: expected a whole number from 1 to {MOST_RECORDINGS}, got {shown(count)}"
        )
    figure = table.get("figure")
    if figure is not None and not isinstance(figure, str):
        raise InputError(f"{where}: figure: expected a text, got {shown(figure)}")
    quantile = number(table.get("quantile", 0.5), f"{where}: quantile", 0.0, 1.0)
    spec, used = _checked(content, axes, where, path, every_cell)
    return Sweep(spec.name, spec.summary, axes, count, figure, quantile, limit, unit, used)


def _checked(
    content: Mapping[str, bytes], axes: tuple[Axis, ...], where: str, path: Path | None, every_cell: bool
) -> tuple[Spec, dict[str, bytes]]:
    """Return the spec of the last cell that was looked at, and the content of all files that cells name."""
    used = dict(content)

    def read(name: str, at: str) -> bytes:
        if name not in used:
            if path is None:
                raise InputError(f"{at}: expected the file '{name}', got none")
            used[name] = beside(path, name, at)
        return used[name]

    def cell(i: int, j: int) -> Spec:
        at = ", ".join(f"{a.name} = {a.shown(a.values[k])}" for a, k in zip(axes, (i, j), strict=False))
        text = _cell_toml(content[SWEEP_FILE], axes, i, j, where)
        return parse_spec({SPEC_FILE: text}, f"{where}, {at}", read)

    spec = cell(0, 0)
    if every_cell:
        rows = len(axes[1].values) if len(axes) > 1 else 1
        for i, j in product(range(len(axes[0].values)), range(rows)):
            spec = cell(i, j)
    return spec, used


def _axes(table: Mapping[str, Any], where: str) -> tuple[Axis, ...]:
    given = table.get("axis")
    if not isinstance(given, list) or not all(isinstance(t, dict) for t in given) or not 1 <= len(given) <= 2:
        raise InputError(f"{where}: expected one or two [[axis]] tables, got {shown(given)}")
    axes = tuple(parse_axis(t, f"{where}: axis[{i}]") for i, t in enumerate(given))
    paths = [path.text for axis in axes for path in axis.parameters]
    if len(set(paths)) < len(paths):
        raise InputError(f"{where}: axis: expected each parameter once, got {', '.join(paths)}")
    cells = len(axes[0].values) * (len(axes[1].values) if len(axes) > 1 else 1)
    if cells > MOST_CELLS:
        raise InputError(f"{where}: axis: expected at most {MOST_CELLS:,} cells, got {cells:,}")
    return axes


def _limit(table: Mapping[str, Any], where: str) -> tuple[str, float]:
    given = [key for key in UNITS if key in table]
    if len(given) != 1:
        raise InputError(
            f"{where}: expected limit_deg, for axes, or limit_mm, for joint centres: the error where the contour is "
            f"drawn; got {' and '.join(given) or 'neither'}"
        )
    return UNITS[given[0]][0], number(table[given[0]], f"{where}: {given[0]}", open_low=True)


def _cell_toml(content: bytes, axes: tuple[Axis, ...], i: int, j: int, where: str = SWEEP_FILE) -> bytes:
    table: dict[str, Any] = deepcopy(dict(parse_toml(content, where)))
    for key in OWN:
        table.pop(key, None)
    table.setdefault("recordings_per_rig", 1)
    for n, (axis, k) in enumerate(zip(axes, (i, j), strict=False)):
        for parameter in axis.parameters:
            parameter.set(table, axis.in_spec[k], f"{where}: axis[{n}].parameter '{parameter.text}'")
    return tomli_w.dumps(table).encode()


@lru_cache(maxsize=512)
def _cell(content: tuple[tuple[str, bytes], ...], where: str) -> Spec:
    return parse_spec(dict(content), where)
