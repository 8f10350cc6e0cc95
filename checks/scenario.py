"""What a claim is tried on: a scenario by name, or what `imubench generate` draws from a spec. Run n follows from n."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from hashlib import sha256
from pathlib import Path
from typing import Any

import tomli_w

from imubench.dataset.playing import make
from imubench.dataset.spec import SPEC_FILE, Spec, parse_spec
from imubench.entry_points import SCENARIOS as POINTS
from imubench.entry_points import offered
from imubench.errors import InputError, shown, unknown
from imubench.inputs.files import below, read_bytes
from imubench.inputs.limits import BINARY_BYTES
from imubench.models.outside import rig_key
from imubench.plugin_versions import module_of, module_version
from imubench.recording import Recording
from imubench.scenarios import SCENARIOS, find_scenario, known_scenarios
from imubench.scenarios.scenario import Scenario as PlayedScenario
from imubench.truth import Truth

SEED = 0
"""Of the spec's draws: run n is recording n of this seed."""


@dataclass(frozen=True)
class Named:
    """A scenario of `imubench list`; run n is that of seed n."""

    name: str

    @property
    def key(self) -> str:
        """What tells it from other scenarios; one of an installed package also from other versions of it."""
        if self.name in SCENARIOS:
            return f"name {self.name}"
        played = find_scenario(self.name)
        if self.name not in offered(POINTS) and isinstance(played, PlayedScenario):
            return f"name {self.name}, {rig_key(played.rig)}"
        return f"name {self.name}, {module_version(module_of(_play(self.name)))}"

    def recording(self, number: int) -> tuple[Recording, Truth]:
        """Return the recording of run `number` and its truth."""
        from imubench.run import simulate  # with all that a run is logged with: only where it is needed

        return simulate(self.name, number)


@dataclass(frozen=True)
class Drawn:
    """A spec of docs/datasets.md with one recording a rig; run n is recording n of seed 0."""

    name: str
    content: tuple[tuple[str, bytes], ...]  # the spec and the files that it names

    @property
    def key(self) -> str:
        """What tells it from other scenarios: a hash of the spec and its files, whatever its name."""
        digest = sha256()
        for name, content in self.content:
            digest.update(f"{name} {len(content)} ".encode() + content)
        for key in _spec(self.content).rig_keys.values():
            digest.update(key.encode())
        return f"spec {digest.hexdigest()[:16]}"

    def recording(self, number: int) -> tuple[Recording, Truth]:
        """Return the recording of run `number` and its truth."""
        made = make(_spec(self.content), SEED, number)
        return made.recording, made.truth


Scenario = Named | Drawn


def _play(name: str) -> Callable[..., object]:
    """Return what plays a scenario of a package; `InputError` where there is none any more."""
    found = find_scenario(name)
    return found.play if isinstance(found, PlayedScenario) else found.record


@lru_cache(16)
def _spec(content: tuple[tuple[str, bytes], ...]) -> Spec:
    return parse_spec(dict(content))


def parse_scenario(given: object, own: Mapping[str, Mapping[str, Any]], folder: Path, where: str) -> Scenario:
    """Return the scenario that a claim names or holds.

    Args:
        given: a name of `own` or of `imubench list`, or a table with the keys of a dataset's spec.
        own: the tables of the claims' file, by name.
        folder: where the files lie that a table names.
        where: what says so, for messages.

    Raises:
        InputError: an unknown name, or a table that is no spec, or one with several recordings a rig.
    """
    if isinstance(given, dict):
        return _drawn("its own table", given, folder, where)
    if not isinstance(given, str):
        raise InputError(f"{where}: expected a scenario's name or a table, got {shown(given)}")
    if given in own:
        return _drawn(given, own[given], folder, f"scenarios.{given}")
    if given not in known_scenarios():
        raise unknown(f"scenario in {where}", given, [*own, *known_scenarios()])
    find_scenario(given)  # a package's may be broken, which is said before any run
    return Named(given)


def own_scenarios(tables: object, where: str) -> Mapping[str, Mapping[str, Any]]:
    """Return the scenarios that a file of claims describes, by name; `InputError` for one that is no table."""
    if not isinstance(tables, dict) or not all(isinstance(table, dict) for table in tables.values()):
        raise InputError(f"{where}: expected [scenarios.NAME] tables, got {shown(tables)}")
    for name in tables:
        if name in known_scenarios():
            raise InputError(f"{where}.{name}: expected a name of its own, got that of a scenario of `imubench list`")
    return tables


def _drawn(name: str, table: Mapping[str, Any], folder: Path, where: str) -> Drawn:
    spec = {"recordings_per_rig": 1, **table}
    if spec["recordings_per_rig"] != 1:
        raise InputError(
            f"{where}: recordings_per_rig: expected 1, for runs that say nothing of each other, "
            f"got {shown(spec['recordings_per_rig'])}"
        )

    def beside(file: str, at: str) -> bytes:
        return read_bytes(below(folder, file, at, "a file beside the claims or below it"), BINARY_BYTES)

    found = parse_spec({SPEC_FILE: tomli_w.dumps(spec).encode()}, where, beside)
    return Drawn(name, tuple(sorted(found.content.items())))
