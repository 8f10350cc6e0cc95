"""diagnosis.json read back, with one line about what is wrong with a broken file."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from imubench.diagnosis.result import (
    TOLERANCE,
    Baseline,
    Change,
    Diagnosis,
    Doubt,
    Finding,
    FitQuality,
    Interval,
    Move,
    Noise,
    Nonsense,
    Own,
    Parameter,
    Rejected,
    SensorErrors,
    SimulatedChannel,
    Simulation,
    Unseen,
    Where,
    finite,
)
from imubench.diagnosis.result_file import FILE_NAME, FORMAT
from imubench.errors import InputError, shown
from imubench.inputs.json import load_json

WORDS: dict[object, str] = {dict: "an object", list: "a list", str: "text", bool: "true or false"}
T = TypeVar("T")


def read_diagnosis(path: Path) -> Diagnosis:
    """Return the diagnosis in a file, or in the folder that `imubench diagnose` wrote.

    Raises `InputError` where the file cannot be read, is no JSON, lacks a key or says what no diagnosis can.
    """
    path = Path(path)
    path = path / FILE_NAME if path.is_dir() else path
    content = load_json(path)
    try:
        return _read_diagnosis(_Node(content, ""))
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


@dataclass(frozen=True)
class _Node:
    """A value in the file and where it stands."""

    value: Any
    where: str

    def __getitem__(self, key: str) -> "_Node":
        table = self.of(dict)
        at = f"{self.where}.{key}" if self.where else key
        if key not in table:
            raise InputError(f"key '{at}': expected, got none")
        return _Node(table[key], at)

    def of(self, kind: type[T]) -> T:
        """Return the value; `InputError` unless it is of a kind."""
        if not isinstance(self.value, kind):
            raise InputError(f"key '{self.where}': expected {WORDS[kind]}, got {shown(self.value)}")
        return self.value

    @property
    def number(self) -> float:
        return finite(self.value, f"key '{self.where}'")

    def each(self, read: "Callable[[_Node], T]") -> tuple[T, ...]:
        """Return what `read` makes of every entry of a list."""
        return tuple(read(_Node(v, f"{self.where}[{i}]")) for i, v in enumerate(self.of(list)))

    def named(self, read: "Callable[[_Node], T]") -> Mapping[str, T]:
        """Return what `read` makes of every entry of an object."""
        return {name: read(self[name]) for name in self.of(dict)}

    def optional(self, key: str, read: "Callable[[_Node], T]", default: T) -> T:
        return read(self[key]) if key in self.of(dict) else default


def _text(node: _Node) -> str:
    return node.of(str)


def _number(node: _Node) -> float:
    return node.number


def _pair(node: _Node) -> tuple[float, float]:
    numbers = node.each(_number)
    if len(numbers) != 2:
        raise InputError(f"key '{node.where}': expected two numbers, got {len(numbers)}")
    return numbers[0], numbers[1]


def _read_diagnosis(node: _Node) -> Diagnosis:
    if node["format"].value != FORMAT:
        raise InputError(f"key 'format': expected {FORMAT}, got {shown(node['format'].value)}")
    misfit, fit = node["misfit"], node["fit"]
    heldout = fit["heldout"]
    found = Diagnosis(
        recording=_text(node["recording"]),
        rig=_text(node["rig"]),
        verdict=_text(node["verdict"]),  # type: ignore[arg-type]  # checked by Diagnosis
        misfit=(misfit["nominal"].number, misfit["explained"].number),
        where=node["where"].each(_read_where),
        findings=node["findings"].each(_read_finding),
        rejected=node["rejected"].each(_read_rejected),
        fit=FitQuality(
            (heldout["before"].number, heldout["after"].number),
            _read_change(fit["left_out_channel"]),
            _read_change(fit["reference"]),
        ),
        model=_text(node["model"]),
        seconds=node["seconds"].number,
        unseen=node.optional("unseen", lambda n: n.each(_read_unseen), ()),
        nonsense=node.optional("nonsense", lambda n: n.each(_read_nonsense), ()),
        stopped=node.optional("stopped", _text, ""),
        not_tried=node.optional("not_tried", lambda n: n.each(_text), ()),
        noise=node.optional("noise", lambda n: n.named(_read_noise), {}),
        doubts=node.optional("doubts", lambda n: n.each(_read_doubt), ()),
        tolerance=node.optional("tolerance", lambda n: (n["deg"].number, n["mm"].number), TOLERANCE),
        sensors=node.optional("sensors", lambda n: n.each(_read_sensor), ()),
        baseline=_read_baseline(node["baseline"]) if "baseline" in node.of(dict) else None,
        moves=node.optional("moves", lambda n: n.named(_read_move), {}),
        simulation=_read_simulation(node["simulation"]) if "simulation" in node.of(dict) else None,
    )
    said = node.optional("alarm", lambda n: n.of(bool), found.alarm)
    if said != found.alarm:
        raise InputError(f"key 'alarm': expected {_word(found.alarm)}, as its findings say, got {_word(said)}")
    return found


def _word(value: bool) -> str:
    return "true" if value else "false"


def _read_doubt(node: _Node) -> Doubt:
    return Doubt(_text(node["of"]), _text(node["why"]))


def _read_noise(node: _Node) -> Noise:
    return Noise(node["std"].number, _text(node["unit"]), _text(node["source"]))


def _read_move(node: _Node) -> Move:
    _all_numbers(node["value"])
    try:
        return Move(node["value"].value, _text(node["unit"]))
    except InputError as error:
        raise InputError(f"key '{node.where}': {error}") from None
    except ValueError:
        raise InputError(f"key '{node.where}': expected rows of equal length, got {shown(node.value)}") from None


def _read_where(node: _Node) -> Where:
    return Where(
        at=_text(node["at"]),
        channels=node["channels"].named(_number),
        bands_hz=node["bands_hz"].each(_pair),
        windows_s=node["windows_s"].each(_pair),
        depends_on=_text(node["depends_on"]),
        share=node["share"].number,
    )


def _read_finding(node: _Node) -> Finding:
    gain = node["heldout_gain"]
    return Finding(
        effect=_text(node["effect"]),
        at=_text(node["at"]),
        confidence=node["confidence"].number,
        parameters=node["parameters"].named(_read_parameter),
        heldout_gain=Interval(gain["value"].number, _pair(gain["ci"]), _text(gain["unit"])),
        equivalent=node["equivalent"].each(_read_rejected),
        separate_by=_text(node["separate_by"]),
        where=node.optional("where", _read_where, None),
        moves=node.optional("moves", lambda n: n.named(_read_move), {}),
        material=node.optional("material", lambda n: n.of(bool), True),
        share=node.optional("share", lambda n: n.number, None),
        unseen=node.optional("unseen", lambda n: n.each(_text), ()),
    )


def _read_parameter(node: _Node) -> Parameter:
    for key in ("value", "std"):
        _all_numbers(node[key])
    try:
        return Parameter(node["value"].value, node["std"].value, _text(node["unit"]))
    except InputError as error:
        raise InputError(f"key '{node.where}': {error}") from None
    except ValueError:
        raise InputError(f"key '{node.where}': expected rows of equal length, got {shown(node.value)}") from None


def _all_numbers(node: _Node) -> None:
    if isinstance(node.value, list):
        node.each(_all_numbers)
    else:
        _number(node)


def _read_rejected(node: _Node) -> Rejected:
    return Rejected(_text(node["effect"]), _text(node["at"]), node["heldout_gain"].number)


def _read_sensor(node: _Node) -> SensorErrors:
    at = _text(node["at"])
    _all_numbers(node["correlation"])
    try:
        return SensorErrors(
            at,
            node["rate"].number,
            node["ranges"].named(_number),
            node["errors"].each(lambda n: Own(_text(n["effect"]), at, n["parameters"].named(_read_parameter))),
            node["correlation"].value,
        )
    except InputError as error:
        raise error if str(error).startswith("key") else InputError(f"key '{node.where}': {error}") from None
    except ValueError:
        raise InputError(f"key '{node.where}.correlation': expected rows of equal length, got others") from None


def _read_baseline(node: _Node) -> Baseline:
    taken = node["taken_over"].each(
        lambda n: Own(_text(n["effect"]), _text(n["at"]), n["parameters"].named(_read_parameter))
    )
    return Baseline(_text(node["recording"]), taken, node.optional("doubt", _text, ""))


def _read_change(node: _Node) -> Change:
    return Change(node["before"].named(_number), node["after"].named(_number), _text(node["unit"]))


def _read_simulation(node: _Node) -> Simulation:
    try:
        return Simulation(
            _text(node["how"]),  # type: ignore[arg-type]  # checked by Simulation
            node["windows_s"].each(_pair),
            node["heldout"].of(bool),
            node["channels"].named(_read_channel),
        )
    except InputError as error:
        raise error if str(error).startswith("key") else InputError(f"key '{node.where}': {error}") from None


def _read_channel(node: _Node) -> SimulatedChannel:
    before, after, noise = (node[key].number for key in ("before", "after", "noise"))
    fit = node["fit"].number if "fit" in node.of(dict) else None
    return SimulatedChannel(_text(node["unit"]), before, after, noise, fit)


def _read_unseen(node: _Node) -> Unseen:
    return Unseen(_text(node["what"]), _text(node["motion"]))


def _read_nonsense(node: _Node) -> Nonsense:
    return Nonsense(
        _text(node["at"]),
        _text(node["what"]),
        node.optional("evidence", lambda n: n.named(_number), {}),
        node.optional("channels", lambda n: n.each(_text), ()),
        node.optional("advice", _text, ""),
        node.optional("missing", lambda n: n.of(bool), False),
    )
