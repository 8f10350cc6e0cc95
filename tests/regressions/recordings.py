"""How the recordings of the regressions are made."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

from imubench.proof.case import make_case
from imubench.proof.mixture import make, mixture
from imubench.trials.make import shortened


class Making(Protocol):
    """How a recording is made."""

    def write(self, folder: Path) -> None:
        """Write the recording into a folder that is not there yet."""


@dataclass(frozen=True)
class Blind:
    """Case `number` of the `count` cases of the blind mixture that a seed makes."""

    seed: int
    count: int
    number: int
    seconds: float = 15.0

    def write(self, folder: Path) -> None:
        """Write its first `seconds`."""
        make(shortened(mixture(self.seed, self.count)[self.number], self.seconds), folder)


@dataclass(frozen=True)
class Made:
    """A recording of the independent generator; effects as `"EFFECT PLACE"` or as the generator takes them."""

    rig: str
    effects: tuple[str | tuple[Any, ...], ...]
    seed: int
    seconds: float = 15.0
    options: Mapping[str, Any] = field(default_factory=dict)

    def write(self, folder: Path) -> None:
        """Write it."""
        effects = [tuple(e.split()) if isinstance(e, str) else e for e in self.effects]
        make_case(folder, self.rig, effects, self.seed, seconds=self.seconds, **self.options)
