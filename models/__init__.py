"""One MJCF file per rig; `RIG_FILES` lists them, `tree` reads them."""

from importlib.resources import files

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


def mjcf(rig: str) -> str:
    """Return the MJCF text of a rig."""
    return (files("imubench.models") / RIG_FILES[rig]).read_text(encoding="utf-8")
