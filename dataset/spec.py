"""A spec: a TOML file of a few lines that says what a dataset is drawn from. docs/datasets.md is its reference."""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from imubench.dataset.effect_ranges import SPRUNG, EffectRange, check_once, parse_effect
from imubench.dataset.imu_choices import ImuChoice, parse_imu
from imubench.dataset.instruments import EncoderRange, PoseRange, parse_encoder, parse_pose
from imubench.dataset.motion_ranges import Files, MotionRange, parse_motion
from imubench.dataset.published.terms import KEYS as TERMS
from imubench.dataset.published.terms import Terms, line_of, parse_terms
from imubench.dataset.ranges import Range, check_keys, chosen, is_number, number, parse_range
from imubench.dataset.rig_ranges import RigRange, parse_rig
from imubench.dataset.swing_range import SwingMotion
from imubench.errors import InputError, shown
from imubench.inputs.files import below, plain_name, read_bytes
from imubench.inputs.limits import BINARY_BYTES
from imubench.inputs.toml import parse_toml
from imubench.models.outside import rig_key
from imubench.sim.injected import rolled_out

KEYS = (
    "format", "name", "summary", *TERMS, "seconds", "rate", "recordings_per_rig", "recordings_per_file",
    "precision", "truth", "declared", "splits", "rig", "motion", "imu", "encoder", "pose", "effect",
)  # fmt: skip
PRECISIONS = ("single", "double")
TRUTHS = ("full", "core", "none")
SPEC_FILE = "spec.toml"
MOTIONS: Sequence[Mapping[str, Any]] = [{"kind": "random"}]  # of a spec that has none
IMUS: Sequence[Mapping[str, Any]] = [{"profile": "xsens_mtw"}]
SPLIT = re.compile(r"[A-Za-z0-9_]{1,60}")  # the name of a split
MOST_SAMPLES = 2_000_000  # of one recording: what fits into a gigabyte on the way


@dataclass(frozen=True)
class Declared:
    """How well the owner of a recording knows its mounts."""

    position_std: float = 0.005  # m
    rotation_std: float = 0.02  # rad


@dataclass(frozen=True)
class Spec:
    """What a dataset is drawn from, checked."""

    name: str
    summary: str
    terms: Terms
    seconds: Range
    rate: float  # Hz, of the IMUs and of the truth
    recordings_per_rig: int
    recordings_per_file: int
    precision: str
    truth: str
    declared: Declared
    splits: Mapping[str, float]  # fractions of the rigs
    rigs: tuple[RigRange, ...]
    motions: tuple[MotionRange, ...]
    imus: tuple[ImuChoice, ...]
    effects: tuple[EffectRange, ...]
    encoder: EncoderRange | None = None
    poses: tuple[PoseRange, ...] = ()
    content: Mapping[str, bytes] = field(repr=False, default_factory=dict)  # the spec's file and those it names

    @property
    def sensors(self) -> int:
        """How many IMUs the largest rig has."""
        return max(len(rig.tree.imus) for rig in self.rigs)

    @property
    def rig_keys(self) -> dict[str, str]:
        """By name of a rig that a package offers: what changes with it."""
        return {rig.family: rig_key(rig.family) for rig in self.rigs if rig.as_built}


def load_spec(path: Path) -> Spec:
    """Return the spec in a TOML file; `InputError` says in one line what is wrong with it."""
    return parse_spec({SPEC_FILE: read_bytes(path)}, str(path), lambda name, where: beside(path, name, where))


def parse_spec(content: Mapping[str, bytes], where: str = SPEC_FILE, files: Files | None = None) -> Spec:
    """Return the spec in `content["spec.toml"]`; the files that it names are in `content` too, or read by `files`.

    Raises `InputError` for an unknown key, a value out of bounds, ranges that make no rig, or rigs without a motion.
    """
    used = dict(content)

    def read(name: str, at: str) -> bytes:
        if name not in used:
            if files is None:
                raise InputError(f"{at}: expected the file '{name}', got none")
            used[name] = files(name, at)
        return used[name]

    table = parse_toml(content[SPEC_FILE], where)
    spec = _parsed(table, where, read)
    _check_fits(spec, where)
    return Spec(**{**spec.__dict__, "content": used})


def _parsed(table: Mapping[str, Any], where: str, read: Files) -> Spec:
    check_keys(table, KEYS, where)
    if table.get("format", 1) != 1:
        raise InputError(f"{where}: format: expected 1, got {table['format']!r}")
    seconds = parse_range(table.get("seconds", 60.0), f"{where}: seconds", 1.0)
    rate = number(table.get("rate", 100.0), f"{where}: rate", 1.0, 10_000.0)
    if seconds.high * rate > MOST_SAMPLES:
        raise InputError(f"{where}: seconds: expected at most {MOST_SAMPLES:,} samples, got {seconds.high * rate:,.0f}")

    def each(key: str, parse: Callable[[Any, str], Any], default: object = None) -> tuple[Any, ...]:
        return tuple(parse(t, f"{where}: {key}[{i}]") for i, t in enumerate(_tables(table, key, where, default)))

    return Spec(
        name=plain_name(table.get("name", "dataset"), f"{where}: name"),
        summary=line_of(table, "summary", "", where),
        terms=parse_terms(table, where),
        seconds=seconds,
        rate=rate,
        recordings_per_rig=_count(table, "recordings_per_rig", 10, where),
        recordings_per_file=_count(table, "recordings_per_file", 50, where),
        precision=chosen(table.get("precision", "single"), f"{where}: precision", PRECISIONS),
        truth=chosen(table.get("truth", "full"), f"{where}: truth", TRUTHS),
        declared=_declared(table.get("declared", {}), f"{where}: declared"),
        splits=_splits(table.get("splits", {"train": 0.8, "validation": 0.1, "test": 0.1}), f"{where}: splits"),
        rigs=each("rig", parse_rig),
        motions=each("motion", lambda t, at: parse_motion(t, at, read, seconds), MOTIONS),
        imus=each("imu", lambda t, at: parse_imu(t, at, read), IMUS),
        effects=each("effect", parse_effect, []),
        encoder=parse_encoder(_table(table.get("encoder"), f"{where}: encoder"), f"{where}: encoder"),
        poses=each("pose", parse_pose, []),
    )


def _check_fits(spec: Spec, where: str) -> None:
    for i, rig in enumerate(spec.rigs):
        if not any(motion.suits(rig) for motion in spec.motions):
            kinds = ", ".join(dict.fromkeys(m.kind for m in spec.motions))
            raise InputError(f"{where}: rig[{i}]: expected a motion that a {rig.base} {rig.family} can do, got {kinds}")
        for kind, ranges in zip(SPRUNG, (rig.soft, rig.rocking), strict=True):
            if ranges.probability and any(e.name == kind for e in spec.effects):
                raise InputError(f"{where}: {kind}: expected springs with the rig or as an effect, got both")
    check_once(spec.effects)
    seen = [pose.segment for pose in spec.poses]
    if len(set(seen)) != len(seen):
        raise InputError(f"{where}: pose: expected each segment once, got {', '.join(seen)}")
    for e in spec.effects:
        if e.name == "backlash" and spec.encoder is None:
            raise InputError(f"{where}: backlash: expected an [encoder], which it shows in, got none")
        if rolled_out(e.name) and not any(m.kind == SwingMotion.kind for m in spec.motions):
            raise InputError(
                f"{where}: {e.name}: expected a motion of kind '{SwingMotion.kind}', which it shows in, got none"
            )


def _tables(table: Mapping[str, Any], key: str, where: str, default: object) -> Sequence[Mapping[str, Any]]:
    given = table.get(key, default)
    if given is None or (given == [] and default != []):
        raise InputError(f"{where}: expected one [[{key}]] or more, got none")
    if not isinstance(given, list) or not all(isinstance(t, dict) for t in given):
        raise InputError(f"{where}: {key}: expected [[{key}]] tables, got {given!r}")
    return given


def _count(table: Mapping[str, Any], key: str, default: int, where: str) -> int:
    value = table.get(key, default)
    if not isinstance(value, int) or isinstance(value, bool) or value < 1:
        raise InputError(f"{where}: {key}: expected a whole number of 1 or more, got {value!r}")
    return value


def _table(table: Any, where: str) -> Any:
    if table is not None and not isinstance(table, dict):
        raise InputError(f"{where}: expected a table, got {table!r}")
    return table


def _declared(table: Any, where: str) -> Declared:
    _table(table, where)
    check_keys(table, ("position_std", "rotation_std"), where)
    return Declared(**{key: number(value, f"{where}.{key}") for key, value in table.items()})


def _splits(table: Any, where: str) -> Mapping[str, float]:
    if not isinstance(table, dict) or not table or not all(is_number(v) and v >= 0 for v in table.values()):
        raise InputError(f"{where}: expected fractions by name, got {table!r}")
    if abs(sum(table.values()) - 1.0) > 1e-9:
        raise InputError(f"{where}: expected fractions that make 1, got {sum(table.values()):g}")
    for name in table:  # files begin with them, and `all` means all splits to `datasets`
        if not SPLIT.fullmatch(name) or name.lower() == "all":
            raise InputError(f"{where}: expected names of letters, digits and _, and not 'all', got {shown(name)}")
    if len({name.lower() for name in table}) < len(table):  # one file on some disks
        raise InputError(f"{where}: expected names that differ in more than case, got {', '.join(table)}")
    return {name: float(value) for name, value in table.items()}


def beside(spec: Path, name: object, where: str) -> bytes:
    """Return the content of a file that a spec names; `InputError` unless it lies beside the spec or below it."""
    if name == SPEC_FILE:
        raise InputError(f"{where}: expected another file than the spec, got '{name}'")
    path = below(spec.parent, name, where, "a file beside the spec or below it")
    try:
        return read_bytes(path, BINARY_BYTES)
    except InputError as error:
        raise InputError(f"{where}: {error}") from None
