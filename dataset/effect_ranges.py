"""Effects with how often they come and how large they are; names, places and parameters are those of `effects`.

A parameter that a spec leaves out comes from the prior that the diagnosis has about it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from imubench.dataset.ranges import Range, check_keys, number, parse_range
from imubench.dataset.rig_ranges import FARTHEST, FASTEST, GYRATION, SPRING_NUMBERS
from imubench.effects import EFFECTS
from imubench.effects.effect import Parameter
from imubench.errors import InputError, unknown
from imubench.models.tree import rig_tree
from imubench.sim.injected import all_injectable, injectable

IMUS = ("imu1", "imu2")
PLACES = {"imu": IMUS, "joint": ("joint",), "body": ("body",), "world": ("world",)}
SPRUNG = ("soft_mount", "rocking_mount")
SLIP_TIME = ("mount_shift", "time")
OPTIONAL = (SLIP_TIME, ("joint_play", "frequency"), ("joint_play", "damping_ratio"))
"""Parameters without which an effect is another one: a slip at some time, a play without springs."""
SLIP_WITHIN = 0.1, 0.9  # of a recording: when a mount slips, if nothing else is said
CHANNELS = ("gyro", "accel")
CHANNELLED: Mapping[str, bool] = {"low_pass": True, "saturation": False, "quantisation": False}  # both at once?
MODES = ("missing", "held")
SHAPES: Mapping[str, Mapping[str, tuple[int, ...]]] = {  # where the law's own parameters are not what is drawn
    "vibration": {"frequency": (), "amplitude": (3,)},
    "impacts": {"count": ()},
    "joint_play": {"range": (), "direction": (), "frequency": (), "damping_ratio": ()},
}
LIMITS: Mapping[str, tuple[float, float, bool]] = {  # [effect.]parameter -> low, high, low excluded
    "frequency": (0.0, np.inf, True),
    "cutoff": (0.0, np.inf, True),
    "limit": (0.0, np.inf, True),
    "step": (0.0, np.inf, True),
    "std": (0.0, np.inf, False),
    "damping_ratio": (0.0, np.inf, False),
    "fraction": (0.0, 0.9, False),
    "count": (0, 1000, False),
    "skew": (-0.1, 0.1, False),
    "offset": (-0.4, 0.4, False),  # s; motions go on for half a second
    "g": (0.0, np.inf, False),
    "time": (0.0, np.inf, False),
    **dict.fromkeys(("c", "t", "d", "k"), (0.0, np.inf, False)),
    "inertia.scale": (0.5, 2.0, False),
    "range": (0.0, np.pi, False),
    "joint_play.range": (0.0, 0.5, True),  # rad; turns across the axis beyond that are no play
    "band": (0.05, 20.0, False),  # Hz
}


@dataclass(frozen=True)
class Shown:
    """What a recording has for effects to show in."""

    family: str
    free: bool  # a free swing
    encoder: bool


@dataclass(frozen=True)
class EffectRange:
    """One `[[effect]]` of a spec."""

    name: str
    places: tuple[str, ...]
    probability: float  # at each place
    ranges: Mapping[str, Range]
    settings: Mapping[str, Any]  # channels, mode

    def suits(self, shown: Shown) -> bool:
        """Return whether a recording can have it."""
        law = EFFECTS[self.name]
        if law.acts("encoder") and not shown.encoder:
            return False
        fits = not shown.free if law.by_hand else shown.free or not law.rolled_out
        return fits and law.fits(rig_tree(shown.family))

    def draw(self, rng: np.random.Generator, places: Sequence[str], seconds: float) -> list[dict[str, Any]]:
        """Return the effects on a recording of `seconds` s, of a rig with these places: name, place, parameters."""
        drawn = []
        for at, own in zip(self.places, rng.spawn(len(self.places)), strict=True):
            if own.random() < self.probability and at in places:
                drawn.append({"effect": self.name, "at": at, "parameters": self._parameters(own, seconds)})
        return drawn

    def _parameters(self, rng: np.random.Generator, seconds: float) -> dict[str, Any]:
        values = {key: _plain(r.draw(rng, _shapes(self.name)[key])) for key, r in self.ranges.items()}
        if self.name == "impacts":
            values = {"times": sorted(_plain(rng.uniform(0.0, seconds, round(values["count"]))))}
        if self.name == "rocking_mount":
            values["gyration"] = GYRATION
        if self.name == "moving_pivot":
            values["band"] = sorted(values["band"])
        if self.name == "mount_shift" and "time" not in values:
            values["time"] = float(seconds * rng.uniform(*SLIP_WITHIN))
        return values | dict(self.settings)


def parse_effect(table: Mapping[str, Any], where: str) -> EffectRange:
    """Return one `[[effect]]`; `InputError` for an unknown name or place, or a parameter out of bounds."""
    name = table.get("name")
    if not isinstance(name, str) or not injectable(name):
        raise unknown(f"{where}.name", name, all_injectable())
    shapes = _shapes(name)
    known = [*shapes, *(["channels"] if name in CHANNELLED else []), *(["mode"] if name == "dropouts" else [])]
    check_keys(table, ("name", "at", "probability", *known), where)
    return EffectRange(
        name,
        _places(table, name, f"{where}.at"),
        number(table.get("probability", 1.0), f"{where}.probability", high=1.0),
        {key: _range(table, name, key, where) for key in shapes if key in table or (name, key) not in OPTIONAL},
        _settings(table, name, where),
    )


def check_once(effects: Sequence[EffectRange]) -> None:
    """Raise `InputError` where an effect could come twice at one place."""
    seen: set[tuple[str, str, str]] = set()
    for effect in effects:
        for at in effect.places:
            for channel in effect.settings.get("channels", [""]):
                key = (effect.name, at, channel)
                if key in seen:
                    raise InputError(f"effect: expected {' '.join(x for x in key if x)} once, got it twice")
                seen.add(key)


def _shapes(name: str) -> Mapping[str, tuple[int, ...]]:
    effect = EFFECTS[name]
    if name in SHAPES:
        return SHAPES[name]
    parameters = {p.name: p.shape for p in effect.parameters if p.reported}
    return parameters | {f.name: tuple(n or 1 for n in f.shape) for f in effect.found}


def _places(table: Mapping[str, Any], name: str, where: str) -> tuple[str, ...]:
    known = PLACES[EFFECTS[name].place]
    default = ["imu2"] if EFFECTS[name].between_sensors else list(known)  # seen only beside another clock
    given = table.get("at", default)
    places = [given] if isinstance(given, str) else given
    if not isinstance(places, list) or not places:
        raise InputError(f"{where}: expected a place or a list of places, got {given!r}")
    for at in places:
        if at not in known:
            raise unknown(where, at, known)
    return tuple(dict.fromkeys(places))


def _range(table: Mapping[str, Any], name: str, key: str, where: str) -> Range:
    low, high, excluded = LIMITS.get(f"{name}.{key}", LIMITS.get(key, (-np.inf, np.inf, False)))
    if name in SPRUNG:
        low, high, excluded = {"frequency": (0.5, FASTEST, False), "com": (-FARTHEST, FARTHEST, False)}.get(
            key, (low, high, excluded)
        )
    if key in table:
        return parse_range(table[key], f"{where}.{key}", low, high, excluded)
    if name in SPRUNG:
        return parse_range(SPRING_NUMBERS[key][0], key)
    prior = next((p for p in EFFECTS[name].parameters if p.name == key), None)
    if prior is None or key not in {p.name for p in EFFECTS[name].parameters if p.reported}:
        raise InputError(f"{where}.{key}: expected a number or a range, got none")
    return _from_prior(prior, low, high)


def _from_prior(prior: Parameter, low: float, high: float) -> Range:
    """Return a range about as wide as a prior, within limits."""
    start = float(np.ravel(prior.start)[0])
    if prior.log:
        return Range("log", start * np.exp(-prior.std), start * np.exp(prior.std))
    if np.isfinite(low) or np.isfinite(high) or prior.sided:
        return Range("uniform", max(start - 2 * prior.std, low), min(start + 2 * prior.std, high))
    return Range("normal", start, prior.std)


def _settings(table: Mapping[str, Any], name: str, where: str) -> dict[str, Any]:
    if name == "dropouts":
        mode = table.get("mode", "missing")
        if mode not in MODES:
            raise unknown(f"{where}.mode", mode, MODES)
        return {"mode": mode}
    if name not in CHANNELLED:
        return {}
    both = CHANNELLED[name]
    channels = table.get("channels", list(CHANNELS) if both else None)
    if not isinstance(channels, list) or not channels or (len(channels) > 1 and not both):
        raise InputError(f"{where}.channels: expected ['gyro'] or ['accel'], got {channels!r}")
    for channel in channels:
        if channel not in CHANNELS:
            raise unknown(f"{where}.channels", channel, CHANNELS)
    return {"channels": channels}


def _plain(value: np.ndarray) -> Any:
    return value.tolist()
