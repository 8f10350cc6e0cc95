"""One MJCF file per rig; `RIG_FILES` lists them."""

from importlib.resources import files

RIG_FILES: dict[str, str] = {
    "hinge": "hinge.xml",
    "pendulum": "pendulum.xml",
    "free": "free.xml",
}


def mjcf(rig: str) -> str:
    """Return the MJCF text of a rig."""
    return (files("imubench.models") / RIG_FILES[rig]).read_text(encoding="utf-8")
