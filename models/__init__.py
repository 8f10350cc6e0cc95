"""One MJCF file per rig; `RIG_FILES` lists ours, `tree` reads them. Installed packages may offer more (`outside`)."""

import re
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

from imubench.entry_points import RIGS as POINTS
from imubench.entry_points import offered, origin

RIG_FILES: dict[str, str] = {
    "hinge": "hinge.xml",
    "pendulum": "pendulum.xml",
    "free": "free.xml",
}

RIG_SUMMARIES: dict[str, str] = {
    "hinge": "two segments on a hinge that a screw can lock, free or fixed base, an IMU on each",
    "pendulum": "a limb on a ball joint, an IMU on it",
    "free": "one body that moves at will, an IMU on it",
}
"""What each is, for people."""

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,59}")
"""What a package may call a rig: a diagnosis writes its model to a file of that name."""


GYRO_SITE = re.compile(r'<gyro [^>]*site="([^"]+)"')
"""In a file of ours, and in one that is put into our form, each IMU has a gyro."""


@dataclass(frozen=True)
class RigFile:
    """A rig as a package offers it by an entry point of the group `imubench.rigs`."""

    summary: str  # one line
    mjcf: str  # the text of an MJCF file that reads no other file


def known_rigs() -> dict[str, str]:
    """Return the rigs by name, each with one line about it; no package is imported for that."""
    outside = {name: origin(points) for name, points in offered(POINTS).items() if NAME.fullmatch(name)}
    return {**RIG_SUMMARIES, **{name: line for name, line in outside.items() if name not in RIG_FILES}}


def is_rig(name: str) -> bool:
    """Return whether a name is that of one of our rigs, or of one that an installed package offers."""
    return name in RIG_FILES or (NAME.fullmatch(name) is not None and name in offered(POINTS))


def mjcf(rig: str) -> str:
    """Return the MJCF text of a rig, a package's in the bench's own frames and names.

    Raises:
        InputError: of a package's that two offer, that cannot be imported, or that is none of the kinds of rig.
    """
    if rig in RIG_FILES:
        return _ours(rig)
    from imubench.models.outside import plain  # needs MuJoCo

    return plain(rig)


def imu_names(rig: str) -> tuple[str, ...]:
    """Return the names of a rig's IMUs, in the order of their segments; `rig_tree` says more, and needs MuJoCo."""
    return tuple(GYRO_SITE.findall(mjcf(rig)))


@cache
def _ours(rig: str) -> str:
    return (files("imubench.models") / RIG_FILES[rig]).read_text(encoding="utf-8")


__all__ = ["NAME", "RIG_FILES", "RIG_SUMMARIES", "RigFile", "imu_names", "is_rig", "known_rigs", "mjcf"]
