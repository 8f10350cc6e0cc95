"""The pytest plugin `imubench_claims`: each claim of a file is a test, which fails with what the runs say.

`pytest --imubench-claims` collects every `*claims.toml`; a file that is named on the command line is collected without
it. Nothing of imubench is imported before a file of claims is met.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from imubench.checks.baseline import Baseline
    from imubench.checks.claim import Claim
    from imubench.checks.runs import Runs

PATTERN = "*claims.toml"
FLAG, AGAINST = "--imubench-claims", "--imubench-against"


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the options."""
    group = parser.getgroup("imubench", "claims about estimators (imubench check)")
    group.addoption(FLAG, action="store_true", default=False, help=f"Collect the claims in every {PATTERN}.")
    group.addoption(
        AGAINST, metavar="FILE", default=None, help="Compare with a baseline, the claims.json of an earlier check."
    )


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> pytest.Collector | None:
    """Return the collector of a file of claims that was asked for, and None for any other file."""
    if not file_path.match(PATTERN):
        return None
    named = parent.session.isinitpath(file_path)
    if not named and not (parent.config.getoption(FLAG) and holds_claims(file_path)):
        return None
    return ClaimsFile.from_parent(parent, path=file_path)


def holds_claims(path: Path) -> bool:
    """Return whether a file has claims of ours, or is meant to: other tools have files of such a name too."""
    from imubench.errors import InputError
    from imubench.inputs.toml import load_toml

    try:
        return "claim" in load_toml(path)
    except InputError:
        return True  # to be told what is wrong with it


class ClaimsFile(pytest.File):
    """A file of claims; its claims share what was run."""

    runs: Runs

    def collect(self) -> Iterator[pytest.Item]:
        """Yield a test for each claim."""
        from imubench.checks.baseline import read_baselines
        from imubench.checks.claim import load_claims
        from imubench.checks.runs import Runs
        from imubench.errors import InputError

        against = self.config.getoption(AGAINST)
        try:
            claims = load_claims(self.path)
            baselines = {} if against is None else read_baselines(Path(against), claims)
        except InputError as error:
            raise self.CollectError(str(error)) from None
        self.runs = Runs(None, 1, None)
        for claim in claims:
            yield ClaimItem.from_parent(self, name=claim.name, claim=claim, baseline=baselines.get(claim.name))

    def teardown(self) -> None:
        """End the process in which estimators ran."""
        from imubench.attempt import own_apart

        own_apart().end()


class ClaimItem(pytest.Item):
    """One claim, checked by as many runs as it needs."""

    def __init__(self, *, claim: Claim, baseline: Baseline | None, **options: Any) -> None:
        super().__init__(**options)
        self.claim, self.baseline = claim, baseline

    def runtest(self) -> None:
        """Check the claim; `ClaimError` where it does not hold."""
        from imubench.checks.check import check
        from imubench.checks.words import measured, paragraph

        assert isinstance(self.parent, ClaimsFile)
        baselines = {} if self.baseline is None else {self.claim.name: self.baseline}
        (done,) = check([self.claim], self.parent.runs, baselines=baselines)
        self.user_properties += [("runs", len(done.errors)), ("measured", measured(done.bound))]
        if not done.holds:
            raise ClaimError("\n\n".join(paragraph(d) for d in done.decisions if d.verdict != "holds"))

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        """Return what the runs say about a claim that failed, or what is wrong with what it names."""
        from imubench.errors import InputError

        if isinstance(excinfo.value, ClaimError | InputError):
            return str(excinfo.value)
        return super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[Path, int | None, str]:
        """Return where the claim stands."""
        return self.path, None, f"claim {self.name}"


class ClaimError(AssertionError):
    """A claim does not hold."""
