"""What every converter is made of: its options, and what it returns."""

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from imubench.errors import InputError, unknown
from imubench.inputs.files import NOTHING, what_is
from imubench.recording import Recording, positive
from imubench.reference import Reference


@dataclass(frozen=True)
class Converted:
    """One recording out of a dataset, the record that judges it, and what its user must know."""

    recording: Recording
    reference: Reference | None
    note: str  # source, licence, what was assumed and what was measured on the way


@dataclass(frozen=True)
class Option:
    """One option of a converter: what it means, and how its text becomes a value."""

    help: str
    parse: Callable[[str], object]
    file: bool = False  # it names a further file


@dataclass(frozen=True)
class Converter:
    """A dataset's or file's way into format 1: call it with the source and its options.

    Options arrive as text from the command line (parsed by the table) or as values from Python.
    Raises `InputError` for a missing source, and for an unknown option or value with the known ones.
    """

    name: str
    summary: str
    convert: Callable[..., list[Converted]]
    options: Mapping[str, Option] = field(default_factory=dict)

    def __call__(self, source: Path, /, **options: object) -> list[Converted]:
        """Return the recordings in `source`, a file or a folder."""
        values = {key: self.parse(key, value) for key, value in options.items()}
        source = Path(source)
        if what_is(source) == NOTHING:
            raise InputError(f"{source}: expected a file or folder for converter {self.name}, got nothing of that name")
        return self.convert(source, **values)

    def files(self, source: Path, options: Mapping[str, object]) -> list[Path]:
        """Return the further files that options name, beside the source or anywhere."""
        named = [str(options[key]) for key, option in self.options.items() if option.file and options.get(key)]
        return [path for name in named for path in (Path(source).parent / name, Path(name)) if what_is(path) != NOTHING]

    def parse(self, key: str, value: object) -> object:
        """Return the value of one option; text and numbers are parsed, anything else is taken as it is."""
        if key not in self.options:
            raise unknown(f"option of {self.name}", key, self.options or ("none",))
        return self.options[key].parse(str(value)) if isinstance(value, str | int | float) else value

    def default(self, key: str) -> object:
        """Return what an option is when it is not given, for help texts."""
        return inspect.signature(self.convert).parameters[key].default


def choice(kind: str, known: tuple[str, ...]) -> Callable[[str], object]:
    """Return a parser for one of the `known` names."""

    def parse(text: str) -> object:
        if text not in known:
            raise unknown(kind, text, known)
        return text

    return parse


def number(kind: str, above_zero: bool = False) -> Callable[[str], object]:
    """Return a parser for a number, if so wanted above zero."""

    def parse(text: str) -> object:
        try:
            value = float(text)
        except ValueError:
            raise InputError(f"{kind}: expected a number, got '{text}'") from None
        positive(abs(value), kind, or_zero=True)  # refuses nan and inf
        if above_zero:
            positive(value, kind)
        return value

    return parse
