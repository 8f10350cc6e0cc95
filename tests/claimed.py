"""Claims for tests: a file of them, and runs that are made up instead of simulated."""

from collections.abc import Generator, Sequence
from pathlib import Path

from imubench.checks.claim import Claim, load_claims
from imubench.checks.runs import Outcome, Runs, Subject

QUICK = """
[scenarios.quick]
seconds = 10
[[scenarios.quick.rig]]
family = "hinge"
"""
"""10 s of a hinge in a hand: 30 ms a run."""
AXIS = """
[claim.axis]
figure = "best_pairing_rmsae"
at_most = "2 deg"
"""


def written(folder: Path, text: str = AXIS, head: str = 'estimator = "seel2012"\nscenario = "quick"\n') -> Path:
    """Return the path of a file of claims."""
    path = folder / "claims.toml"
    path.write_text(head + QUICK + text)
    return path


def loaded(folder: Path, text: str = AXIS) -> list[Claim]:
    """Return claims."""
    return list(load_claims(written(folder, text)))


class MadeUp(Runs):
    """Runs with given errors of one figure, in rad; None where there is no estimate."""

    def __init__(self, errors: Sequence[float | None], figure: str = "best_pairing_rmsae") -> None:
        super().__init__(None, 1, None)
        self.errors, self.figure, self.made = errors, figure, 0

    def of(self, subject: Subject, first: int) -> Generator[Outcome, None, None]:
        """Yield them from number `first` on, and again from the start."""
        number = first
        while True:
            self.made += 1
            error = self.errors[number % len(self.errors)]
            yield Outcome({}, "crashed: no") if error is None else Outcome({self.figure: error})
            number += 1
