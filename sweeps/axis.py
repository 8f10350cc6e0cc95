"""An axis of a sweep: which numbers of the spec change, over which values."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from imubench.arrays import Array
from imubench.dataset.ranges import check_keys, chosen, is_number, number
from imubench.dataset.spec import IMUS, MOTIONS
from imubench.errors import InputError, shown, unknown
from imubench.sweeps.units import factor, unit_of

KEYS = ("parameter", "values", "from", "to", "count", "scale", "unit", "label")
SCALES = ("linear", "log")
MOST = 200  # values of an axis: more do not fit beside each other on a page
PART = re.compile(r"([A-Za-z_][A-Za-z0-9_-]*)(?:\[(\d+)\])?")
TABLES: Mapping[str, Sequence[Mapping[str, Any]]] = {  # of which a spec has any number -> what it has by default
    "rig": [],
    "motion": MOTIONS,
    "imu": IMUS,
    "pose": [],
    "effect": [],
}


@dataclass(frozen=True)
class Parameter:
    """Where a number stands in a spec: `effect.soft_mount.frequency`, `rig.mount_distance`, `rig[1].soft.frequency`."""

    text: str
    keys: tuple[str, ...]
    places: tuple[int | None, ...]  # the number of the table among those of its name; None: all of them

    def set(self, table: dict[str, Any], value: object, where: str) -> None:
        """Put a value there; `InputError` where the spec has no such table."""
        at = [table]
        for depth, (key, place) in enumerate(zip(self.keys[:-1], self.places, strict=False)):
            at = self._next(at, key, place, depth, where)
        for found in at:
            found[self.keys[-1]] = value

    def _next(
        self, at: list[dict[str, Any]], key: str, place: int | None, depth: int, where: str
    ) -> list[dict[str, Any]]:
        if depth == 1 and self.keys[0] == "effect":
            own = [t for t in at if t.get("name") == key]
            if not own:
                have = ", ".join(str(t.get("name")) for t in at) or "none"
                raise InputError(f"{where}: expected an [[effect]] with name = '{key}', got {have}")
            return own
        found: list[dict[str, Any]] = []
        for one in at:
            inner = one.setdefault(key, [dict(t) for t in TABLES[key]] if depth == 0 and key in TABLES else {})
            tables = inner if isinstance(inner, list) else [inner]
            if not all(isinstance(t, dict) for t in tables):
                tables = [{}]  # a plain number or a range gives way to a table
                one[key] = tables[0]
            if place is not None and place >= len(tables):
                raise InputError(f"{where}: expected [[{key}]] number {place}, got {len(tables)} of them")
            if not tables:
                raise InputError(f"{where}: expected a [[{key}]] in the spec, got none")
            found += tables if place is None else [tables[place]]
        return found


@dataclass(frozen=True)
class Axis:
    """The values of one axis and what they are put into."""

    parameters: tuple[Parameter, ...]
    values: tuple[float | str, ...]  # as given, in `unit`
    in_spec: tuple[float | str, ...]  # as the spec has them, SI
    unit: str  # "" for texts and numbers without one
    scale: str  # linear or log
    label: str

    @property
    def name(self) -> str:
        """The name of its column: that of the first parameter."""
        return self.parameters[0].text

    @property
    def is_text(self) -> bool:
        """Whether the values are texts, such as names of IMU profiles."""
        return isinstance(self.values[0], str)

    @property
    def places(self) -> Array:
        """Where the values stand (n,): they themselves, or 0, 1, ... of texts."""
        return np.arange(len(self.values), dtype=float) if self.is_text else np.array(self.values, dtype=float)

    def shown(self, value: float | str) -> str:
        """Return a value with its unit, for people."""
        text = value if isinstance(value, str) else f"{value:.3g}"
        return f"{text} {printed(self.unit)}".strip()

    @property
    def title(self) -> str:
        """The label with the unit."""
        return f"{self.label}, {printed(self.unit)}" if self.unit else self.label


def printed(unit: str) -> str:
    """Return a unit as people write it."""
    return unit.replace("^2", "²").replace("^3", "³")


def parse_axis(table: Mapping[str, Any], where: str) -> Axis:
    """Return one `[[axis]]`; `InputError` for a path that is none, values that are no axis, or a foreign unit."""
    check_keys(table, KEYS, where)
    paths = _paths(table.get("parameter"), f"{where}.parameter")
    values, scale = _values(table, where)
    text = isinstance(values[0], str)
    known = {unit_of(path.keys) for path in paths}
    if len(known) > 1:
        raise InputError(f"{where}.parameter: expected numbers of one unit, got {', '.join(map(str, known))}")
    si = next(iter(known))
    unit = table.get("unit", "" if si is None or text else si)
    if not isinstance(unit, str) or (text and unit):
        raise InputError(f"{where}.unit: expected {'none for texts' if text else 'a text'}, got {shown(unit)}")
    size = factor(unit, si, f"{where}.unit") if unit else 1.0
    in_spec = tuple(v if isinstance(v, str) else _rounded(v * size) for v in values)
    label = table.get("label", _label(paths))
    if not isinstance(label, str) or not label or "\n" in label:
        raise InputError(f"{where}.label: expected a line of text, got {shown(label)}")
    return Axis(paths, values, in_spec, "" if unit == "1" else unit, scale, label)


def _rounded(value: float) -> float:
    """Return a number without the last digits, which a factor between units fills with rounding."""
    return float(f"{value:.14g}")


def _paths(given: object, where: str) -> tuple[Parameter, ...]:
    texts = [given] if isinstance(given, str) else given
    if not isinstance(texts, list) or not texts or not all(isinstance(t, str) for t in texts):
        raise InputError(
            f"{where}: expected a path such as 'effect.soft_mount.frequency', or some of them, got {shown(given)}"
        )
    return tuple(parse_parameter(text, where) for text in texts)


def parse_parameter(text: str, where: str) -> Parameter:
    """Return the parameter that a text stands for; `InputError` where it is none."""
    found = [PART.fullmatch(part) for part in text.split(".")]
    if not all(found):
        raise InputError(f"{where}: expected names between points, as 'rig[1].soft.frequency', got {shown(text)}")
    parts = [(str(m[1]), None if m[2] is None else int(m[2])) for m in found if m is not None]
    if len(parts) < (3 if parts[0][0] == "effect" else 2 if parts[0][0] in TABLES else 1):
        raise InputError(f"{where}: expected a path down to a number, got {shown(text)}")
    if parts[0][0] == "axis":
        raise unknown(f"table in {where}", "axis", TABLES)
    return Parameter(text, tuple(k for k, _ in parts), tuple(p for _, p in parts))


def _label(paths: tuple[Parameter, ...]) -> str:
    """Return `frequency of soft_mount`, `bias std of gyro_bias`: the last keys, and whose they are."""
    owned = paths[0].keys[2:] if paths[0].keys[0] == "effect" else paths[0].keys[-1:]
    last = " ".join(owned).replace("_", " ")
    owners = dict.fromkeys(p.keys[-len(owned) - 1] for p in paths if len(p.keys) > len(owned))
    return f"{last} of {' and '.join(owners)}" if owners else last


def _values(table: Mapping[str, Any], where: str) -> tuple[tuple[float | str, ...], str]:
    scale = chosen(table.get("scale", "linear"), f"{where}.scale", SCALES)
    if "values" in table:
        for key in ("from", "to", "count"):
            if key in table:
                raise InputError(f"{where}: expected values or from, to and count, got both")
        values = table["values"]
        texts = isinstance(values, list) and bool(values) and all(isinstance(v, str) for v in values)
        if not texts and not (isinstance(values, list) and all(is_number(v) for v in values)):
            raise InputError(f"{where}.values: expected a list of numbers, or of texts, got {shown(values)}")
        found: tuple[float | str, ...] = tuple(v if isinstance(v, str) else float(v) for v in values)
    else:
        found = _spaced(table, scale, where)
    if not 2 <= len(found) <= MOST:
        raise InputError(f"{where}: expected 2 to {MOST} values, got {len(found)}")
    if isinstance(found[0], str):
        if len(set(found)) < len(found):
            raise InputError(f"{where}.values: expected each text once, got {shown(list(found))}")
    elif np.any(np.diff(np.array(found, dtype=float)) <= 0):
        raise InputError(f"{where}.values: expected numbers that rise, got {shown(list(found))}")
    elif scale == "log" and float(found[0]) <= 0:
        raise InputError(f"{where}: expected values above 0 for scale = 'log', got {found[0]}")
    return found, scale


def _spaced(table: Mapping[str, Any], scale: str, where: str) -> tuple[float, ...]:
    low, high = (number(table.get(key), f"{where}.{key}", -np.inf) for key in ("from", "to"))
    count = table.get("count")
    if not isinstance(count, int) or isinstance(count, bool) or not 2 <= count <= MOST:
        raise InputError(f"{where}.count: expected a whole number from 2 to {MOST}, got {shown(count)}")
    if not low < high:
        raise InputError(f"{where}: expected from < to, got {low:g} and {high:g}")
    if scale == "log" and low <= 0:
        raise InputError(f"{where}.from: expected a number above 0 for scale = 'log', got {low:g}")
    spaced = np.geomspace(low, high, count) if scale == "log" else np.linspace(low, high, count)
    # Four digits are what a map can show, and what stands in the tables is then what was played.
    return tuple(float(f"{v:.4g}") for v in spaced)
