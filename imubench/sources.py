"""A recording by the name that a command is given: a folder in format 1, or DIR#17, recording 17 of a dataset.

Wherever a recording is asked for, this is how it is found and read.
"""

import re
from pathlib import Path

from imubench.inputs.files import NOTHING, real, what_is
from imubench.recording import Recording
from imubench.reference import Reference

Source = Path | str
"""The folder of a recording in format 1, or the folder or URL of a dataset with `#` and the recording's number."""

NUMBERED = re.compile(r"(.+)#(\d{1,10})", re.DOTALL)


def read(source: Source) -> tuple[Recording, Reference | None]:
    """Return a recording and its reference.

    Args:
        source: the folder of a recording in format 1, or `DIR#17`. A folder that has this very name comes first. Of a
            dataset the reference is its truth, as far as it is stored and a laboratory could measure it.

    Raises:
        InputError: no recording there, a dataset without that number, and as `format1.read` and `dataset.read` do.
    """
    numbered = in_dataset(source)
    if numbered is None:
        from imubench import format1

        return format1.read(Path(source))
    from imubench.dataset.reading import read as read_stored

    stored = read_stored(*numbered)
    return stored.recording, stored.reference


def in_dataset(source: Source) -> tuple[str, int] | None:
    """Return folder or URL and number of a dataset's recording; None for any other source."""
    found = NUMBERED.fullmatch(_text(source))
    if found is None or what_is(Path(source)) != NOTHING:
        return None
    return found[1], int(found[2])


def folder_of(source: Source) -> Path | None:
    """Return the folder that a source is read from; None for a URL."""
    numbered = in_dataset(source)
    text = str(source) if numbered is None else numbered[0]
    return None if "://" in text else Path(text)


def label(source: Source) -> str:
    """Return a name for a folder about a recording: its own folder's, or DIR-17."""
    numbered = in_dataset(source)
    if numbered is None:
        return real(source).name
    return f"{real(numbered[0]).name}-{numbered[1]}"


def _text(source: Source) -> str:
    """Return a source as it was typed: `Path` takes the second of the slashes that a URL begins with."""
    if isinstance(source, str):
        return source
    found = re.fullmatch(r"([a-z][a-z0-9+.-]+):/(?!/)(.*)", str(source), re.DOTALL)
    if found is None:
        return str(source)
    return f"{found[1]}:///{found[2]}" if found[1] == "file" else f"{found[1]}://{found[2]}"
