"""Sequences as data: which motions, cut where, how often. The form of the file is told in sequences.toml."""

from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

from imubench.errors import InputError, unknown
from imubench.inputs.toml import load_toml, parse_toml
from imubench.scenarios.olsson2020.motions import MOTIONS

TABLE_KEYS = ("summary", "pieces")
PIECE_KEYS = ("motion", "seconds", "half", "repeat")


@dataclass(frozen=True)
class Piece:
    """A motion of a sequence, whole or a part of it."""

    motion: int
    seconds: tuple[float, float] | None = None  # of the motion
    half: int | None = None  # 1 or 2; instead of seconds
    repeat: int = 1

    def cut(self, duration: float, where: str) -> tuple[float, float]:
        """Return start and end (s) of the piece in a motion of `duration` s; `InputError` if it is shorter."""
        if self.half is not None:
            return (self.half - 1) * duration / 2, self.half * duration / 2
        if self.seconds is None:
            return 0.0, duration
        start, end = self.seconds
        if end > duration:
            raise InputError(
                f"{where}: expected a cut within the {duration:g} s of motion {self.motion}, got {end:g} s"
            )
        return start, end


@dataclass(frozen=True)
class Plan:
    """A sequence as it is written down."""

    name: str
    pieces: tuple[Piece, ...]
    summary: str = ""


def find(which: str | Path) -> Plan:
    """Return a sequence by name, or from a file: FILE.toml holding one, or FILE.toml#NAME.

    Raises `InputError` for an unknown name, an unreadable file, or one that says something else than
    sequences.toml explains.
    """
    text = str(which)
    path, _, name = text.partition("#")
    if not path.endswith(".toml"):
        if text not in SEQUENCES:
            raise unknown("sequence", text, (*SEQUENCES, "a path to a .toml file"))
        return SEQUENCES[text]
    plans = load(Path(path))
    if name:
        if name not in plans:
            raise unknown(f"sequence in {path}", name, plans)
        return plans[name]
    if len(plans) != 1:
        raise InputError(f"{path}: expected one sequence or {path}#NAME, got {', '.join(plans) or 'none'}")
    return next(iter(plans.values()))


def load(path: Path) -> dict[str, Plan]:
    """Return the sequences of a TOML file by name; `InputError` says what is wrong with it."""
    return _plans(load_toml(path), str(path))


def parse(content: bytes, where: str) -> dict[str, Plan]:
    """Return the sequences in the bytes of a TOML file by name; `InputError` says what is wrong with them."""
    return _plans(parse_toml(content, where), where)


def _plans(tables: dict[str, Any], where: str) -> dict[str, Plan]:
    return {name: _plan(name, table, f"{where}: {name}") for name, table in tables.items()}


def _plan(name: str, table: object, where: str) -> Plan:
    if not isinstance(table, dict):
        raise InputError(f"{where}: expected a table, got {table!r}")
    _check_keys(table, TABLE_KEYS, where)
    summary, pieces = table.get("summary", ""), table.get("pieces")
    if not isinstance(summary, str):
        raise InputError(f"{where}.summary: expected a text, got {summary!r}")
    if not isinstance(pieces, list) or not pieces:
        raise InputError(f"{where}.pieces: expected a list of motions, got {pieces!r}")
    return Plan(name, tuple(_piece(p, f"{where}.pieces[{i}]") for i, p in enumerate(pieces)), summary)


def _piece(entry: object, where: str) -> Piece:
    if isinstance(entry, dict):
        _check_keys(entry, PIECE_KEYS, where)
        table: Mapping[str, Any] = entry
    else:
        table = {"motion": entry}
    motion, half, repeat = table.get("motion"), table.get("half"), table.get("repeat", 1)
    if not _whole(motion):
        raise InputError(f"{where}: expected a motion's number, got {motion!r}")
    if motion not in MOTIONS:
        raise unknown(f"motion in {where}", motion, MOTIONS)
    if "half" in table and not (_whole(half) and half in (1, 2)):
        raise InputError(f"{where}.half: expected 1 or 2, got {half!r}")
    if "half" in table and "seconds" in table:
        raise InputError(f"{where}: expected seconds or half, got both")
    if not _whole(repeat) or repeat < 1:
        raise InputError(f"{where}.repeat: expected a whole number of 1 or more, got {repeat!r}")
    return Piece(motion, _seconds(table, where), half, repeat)


def _seconds(table: Mapping[str, Any], where: str) -> tuple[float, float] | None:
    if "seconds" not in table:
        return None
    given = table["seconds"]
    numbers = isinstance(given, list) and len(given) == 2 and all(type(x) in (int, float) for x in given)
    if not numbers or not 0 <= given[0] < given[1] < float("inf"):
        raise InputError(f"{where}.seconds: expected [start, end] with 0 <= start < end, got {given!r}")
    return float(given[0]), float(given[1])


def _check_keys(table: Mapping[str, Any], known: tuple[str, ...], where: str) -> None:
    for key in table:
        if key not in known:
            raise unknown(f"key in {where}", key, known)


def _whole(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)


SEQUENCES = parse((files("imubench.scenarios.olsson2020") / "sequences.toml").read_bytes(), "sequences.toml")
"""The paper's four sequences, by name."""
