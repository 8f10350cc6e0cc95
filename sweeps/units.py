"""Units in which a sweep may give and show a parameter, and the one in which a dataset's spec has it."""

from collections.abc import Mapping

import numpy as np

from imubench.effects import EFFECTS
from imubench.errors import unknown
from imubench.sim.profiles import ANGULAR_RATE, HERTZ, PLAIN, SECONDS, SPECIFIC_FORCE, Units
from imubench.units import ANGLE, LENGTH

MASS: Units = {"kg": 1.0, "g": 1e-3}
ALIKE: Mapping[str, Units] = {
    "1": PLAIN,
    "s": SECONDS,
    "Hz": HERTZ,
    "rad/s": ANGULAR_RATE,
    "m/s^2": SPECIFIC_FORCE,
    "m": LENGTH,
    "rad": ANGLE,
    "kg": MASS,
    "rad/rad": {"rad/rad": 1.0, "deg/deg": 1.0, "%": 1e-2},
    "m/rad": {"m/rad": 1.0, "mm/rad": 1e-3, "mm/deg": 1e-3 * 180 / np.pi},
}
"""SI unit -> the units that measure the same, and what one of each is in SI."""
KEYS: Mapping[str, str] = {  # of a spec's tables; see docs/datasets.md
    "seconds": "s",
    "rate": "Hz",
    "position_std": "m",
    "rotation_std": "rad",
    **dict.fromkeys(("mount_distance", "mount_offset", "segment_length", "segment_radius", "com", "lever"), "m"),
    "mount_rotation": "rad",
    "segment_mass": "kg",
    "gravity": "m/s^2",
    "frequency": "Hz",
    "bandwidth": "Hz",
    **dict.fromkeys(("turn", "angle", "angle_mean", "deflection", "zero", "rotation_noise_std"), "rad"),
    **dict.fromkeys(("shift", "position_noise_std"), "m"),
    **dict.fromkeys(("damping_ratio", "probability", "weight", "amplitude", "pace"), "1"),
}
ENCODER_STD = "rad"
ACCELS = ("saturation", "quantisation")  # whose unit depends on the channel


def unit_of(keys: tuple[str, ...]) -> str | None:
    """Return the SI unit of a parameter, None where that is not known; `keys` is its path without places."""
    table, name = keys[0], keys[-1]
    if table == "effect" and len(keys) > 2:
        if keys[1] in ACCELS:
            return None
        law, key = EFFECTS.get(keys[1]), keys[2]
        if name == "probability" or law is None:
            return KEYS.get(name)
        known = {p.name: p.unit for p in law.parameters} | {f.name: f.unit for f in law.found}
        return known.get(key, KEYS.get(key))
    if table == "motion" and name == "rate":
        return "rad/s"  # of a swing that is let go
    if table == "encoder" and name == "noise_std":
        return ENCODER_STD
    return KEYS.get(next((key for key in keys if key in KEYS), name))


def factor(unit: str, of: str | None, where: str) -> float:
    """Return what one `unit` is in the SI unit `of`; `InputError` where it measures something else."""
    if of is None:
        known = {name: value for units in ALIKE.values() for name, value in units.items()}
    else:
        known = dict(ALIKE.get(of, {of: 1.0}))
    if unit not in known:
        raise unknown(f"unit in {where}", unit, known)
    return known[unit]
