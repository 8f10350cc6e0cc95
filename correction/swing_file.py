"""Free swings in a model's imus.toml: `[[free_swing]]` tables with the state at each start.

start, end    s, the recording's clock
angle         rad, the hinge's, with angle_rate rad/s
quaternion    w, x, y, z of a limb on a ball joint, segment -> world, with rate (3) rad/s in segment axes
"""

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.correction import READ_MODEL
from imubench.diagnosis.evidence import Swing
from imubench.errors import InputError, shown
from imubench.models.tree import rig_tree
from imubench.sim.swing import Start

KEY = "free_swing"


def swing_tables(swings: Iterable[Swing], rig: str) -> list[dict[str, Any]]:
    """Return the free swings of a rig for imus.toml."""
    out = []
    for swing in swings:
        state = swing.state
        if rig_tree(rig).hinge is not None:
            told: dict[str, Any] = {"angle": float(state.angle), "angle_rate": float(state.angle_rate)}
        else:
            told = {"quaternion": state.quaternion.tolist(), "rate": state.rate.tolist()}
        out.append({"start": float(swing.start), "end": float(swing.end), **told})
    return out


def read_swings(
    tables: Iterable[Mapping[str, Any]], rig: str, span: tuple[float, float], where: str
) -> tuple[Swing, ...]:
    """Return the free swings in the tables of imus.toml.

    Args:
        tables: as they were read.
        rig: its name; of one with a hinge or a ball joint.
        span: s, of the samples, that swings lie in.
        where: the file, for what is wrong with it.

    Raises:
        InputError: for a key that is missing or no number, an end before its start, and for swings that overlap or go
            on beyond the samples.
    """
    out: list[Swing] = []
    for i, table in enumerate(tables):
        at = f"{where}, {KEY}[{i}]"
        start, end = (float(_numbers(table, key, (), at)) for key in ("start", "end"))
        if rig_tree(rig).hinge is not None:
            angle, rate = (float(_numbers(table, key, (), at)) for key in ("angle", "angle_rate"))
            state = Start(angle=angle, angle_rate=rate)
        else:
            state = Start(quaternion=_numbers(table, "quaternion", (4,), at), rate=_numbers(table, "rate", (3,), at))
        if not end > start or (out and start < out[-1].end):
            raise InputError(
                f"{at}: expected a swing that ends after its start and begins after the one before it, "
                f"got {start:g} to {end:g} s"
            )
        if start < span[0] - READ_MODEL.rounding_s or end > span[1] + READ_MODEL.rounding_s:
            raise InputError(
                f"{at}: expected a swing within the samples' {span[0]:g} to {span[1]:g} s, got {start:g} to {end:g} s"
            )
        out.append(Swing(max(start, span[0]), end, state))
    return tuple(out)


def _numbers(table: Mapping[str, Any], key: str, shape: tuple[int, ...], where: str) -> Array:
    """Return finite numbers of a shape."""
    value = table.get(key)
    try:
        found = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        found = np.full((), np.nan)
    if found.shape != shape or not np.isfinite(found).all() or isinstance(value, bool | str):
        expected = f"{shape[0]} finite numbers" if shape else "a finite number"
        raise InputError(f"{where}, key '{key}': expected {expected}, got {shown(value)}")
    return found


__all__ = ["KEY", "read_swings", "swing_tables"]
