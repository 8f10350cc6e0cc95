"""MJCF files of strangers: read without another file, and bounded before MuJoCo builds anything."""

import re
from pathlib import Path
from typing import Any
from xml.parsers import expat

from imubench.errors import InputError, first_line
from imubench.inputs.files import read_bytes
from imubench.inputs.limits import DEPTH, ELEMENTS, PIXELS, TEXT_BYTES

MULTIPLYING = ("replicate", "composite", "flexcomp", "attach")
"""Elements that stand for many others."""

READING = ("include", "extension", "plugin", "model", "skin", "flex", "mesh", "hfield", "texture")
"""Elements that may read other files, or hold more than what is written."""

FILES = re.compile(r"file\w*|content_type|\w*dir")  # attributes that name files and folders
SIZES = (("width", "height"), ("nrow", "ncol"))  # attributes whose product is allocated
NOT_FINITE = {"nan", "inf", "infinity"}  # of which MuJoCo warns on a line of its own
COUNTING, COUNTS = ("numeric", "user"), ("size", "dim", "nsample")  # elements that hold so many numbers
MEMORY = (
    "memory", "nstack", "njmax", "nconmax", "nuserdata", "nkey", "nuser_body", "nuser_jnt", "nuser_geom",
    "nuser_site", "nuser_cam", "nuser_tendon", "nuser_actuator", "nuser_sensor",
)  # fmt: skip
"""Attributes of <size> that MuJoCo allocates by."""


def load_mjcf(path: Path) -> Any:
    """Return the `mujoco.MjSpec` of an MJCF file that stands alone.

    Args:
        path: the file.

    Raises:
        InputError: no XML, no MJCF, an element that reads another file or stands for many, or beyond the limits.
    """
    return parsed_mjcf(read_bytes(path, TEXT_BYTES), str(path))


def parsed_mjcf(content: bytes, where: str) -> Any:
    """Return the `mujoco.MjSpec` of what an MJCF file holds, `where` its name; `InputError` as `load_mjcf`."""
    import mujoco

    text = checked_mjcf(content, where)
    try:
        return mujoco.MjSpec.from_string(text)
    except (ValueError, mujoco.FatalError) as error:
        raise _no_model(where, error) from None


def compiled(path: Path) -> Any:
    """Return the `mujoco.MjModel` of an MJCF file that stands alone; `InputError` as `load_mjcf`."""
    return compiled_mjcf(load_mjcf(path), str(path))


def compiled_mjcf(spec: Any, where: str) -> Any:
    """Return the `mujoco.MjModel` of a `mujoco.MjSpec`; `InputError` where it makes none."""
    import mujoco

    try:
        return spec.compile()
    except (ValueError, mujoco.FatalError) as error:
        raise _no_model(where, error) from None


def _no_model(where: str, error: Exception) -> InputError:
    return InputError(f"{where}: expected an MJCF model, got: {first_line(error)}")


def checked_mjcf(content: bytes, where: str) -> str:
    """Return the text of an MJCF file that reads no other file and stays within the limits; `InputError` otherwise."""
    parser = expat.ParserCreate()
    depth, count = 0, 0

    def declared(*_: object) -> None:
        raise InputError(f"{where}: expected MJCF without a document type, got one")

    def begin(name: str, attributes: dict[str, str]) -> None:
        nonlocal depth, count
        depth, count = depth + 1, count + 1
        at = f"{where}, line {parser.CurrentLineNumber}"
        if depth > DEPTH:
            raise InputError(f"{at}: expected elements at most {DEPTH} deep, got deeper ones")
        if count > ELEMENTS:
            raise InputError(f"{at}: expected at most {ELEMENTS:,} elements, got more")
        if count == 1 and name != "mujoco":
            raise InputError(f"{at}: expected <mujoco> outermost, got <{name}>")
        _check_element(name, attributes, at)

    def end(_: str) -> None:
        nonlocal depth
        depth -= 1

    parser.StartDoctypeDeclHandler = declared
    parser.StartElementHandler, parser.EndElementHandler = begin, end
    try:
        parser.Parse(content, True)
        return content.decode()
    except expat.ExpatError as error:
        raise InputError(f"{where}: expected XML, got: {error}") from None
    except UnicodeDecodeError as error:
        raise InputError(f"{where}: expected UTF-8 text, got byte 0x{content[error.start]:02x}") from None


def _check_element(name: str, attributes: dict[str, str], at: str) -> None:
    if name in MULTIPLYING:
        raise InputError(f"{at}: expected elements that stand for themselves, got <{name}>")
    for key, value in attributes.items():
        if not value.isprintable() and not all(c.isprintable() or c in "\n\t" for c in value):
            raise InputError(f"{at}: expected text without control characters, got {key}='{value}' in <{name}>")
        if NOT_FINITE & set(value.lower().replace("-", "").replace("+", "").split()):
            raise InputError(f"{at}: expected finite numbers, got {key}='{value}' in <{name}>")
        if FILES.fullmatch(key) and value:
            raise InputError(f"{at}: expected a model that reads no other file, got {key}='{value}' in <{name}>")
    if name in READING and not _built_in(name, attributes):
        raise InputError(f"{at}: expected a model that reads no other file, got <{name}>")
    for pair in SIZES:
        sizes = [_whole(attributes.get(key, "1"), f"{at}, {key} of <{name}>") for key in pair]
        if sizes[0] * sizes[1] > PIXELS:
            raise InputError(f"{at}: expected at most {PIXELS:,} pixels, got {sizes[0]:,} x {sizes[1]:,} in <{name}>")
    for key in COUNTS:
        for text in attributes.get(key, "").split() if name in COUNTING else ():
            if _whole(text, f"{at}, {key} of <{name}>") > ELEMENTS:
                raise InputError(f"{at}: expected at most {ELEMENTS:,}, got {key}='{text}' in <{name}>")
    for key in MEMORY:
        if name == "size" and key in attributes:
            raise InputError(f"{at}: expected sizes that MuJoCo finds itself, got {key} in <size>")


def _built_in(name: str, attributes: dict[str, str]) -> bool:
    """Return whether an asset is a pattern that MuJoCo paints."""
    return name == "texture" and attributes.get("builtin", "none") != "none"


def _whole(text: str, at: str) -> int:
    try:
        value = int(text)
    except ValueError:
        raise InputError(f"{at}: expected a whole number, got '{text}'") from None
    if not 0 <= value < 2**31:
        raise InputError(f"{at}: expected a whole number from 0 on, got '{text}'")
    return value
