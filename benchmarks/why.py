"""Why a diagnosis says what it says: what the search proposed, which tests each proposal met, and by how much.

    python -m benchmarks.why RECORDING [--set RECORD.FIELD=VALUE ...] [--without RULE ...]

`RECORDING` is a folder in format 1. `--set` gives a threshold of docs/thresholds.md another value, in this run alone;
`--without` leaves out a rule of `imubench list rules`. What is printed can be compared: run it with and without, and
`diff` the two.
"""

import argparse
import ast
import inspect
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from imubench.errors import InputError, unknown
from imubench.threshold_table import modules, records

if TYPE_CHECKING:
    from imubench.diagnosis.criteria.trial import Gain
    from imubench.diagnosis.search.moves.move import Above, Answer, Foretells, Holds, Proposal, SearchState

    Test = Above | Holds | Foretells

# What decides by thresholds is imported where it is used: a default, or a number computed from others, is read then.
DECIDES = "imubench.diagnosis.pipeline"


def set_threshold(text: str) -> None:
    """Give a threshold another value, for modules that are not imported yet.

    Args:
        text: RECORD.FIELD=VALUE, as `EVIDENCE.needed_nat=50`.

    Raises:
        InputError: for another form, an unknown record or field, or a value of another kind.
        RuntimeError: where the diagnosis has been imported, which has read its thresholds then.
    """
    if DECIDES in sys.modules:
        raise RuntimeError("expected thresholds to be set before the diagnosis is imported, got one after it")
    place, equals, value = text.partition("=")
    record, dot, field = place.strip().partition(".")
    if not (equals and dot):
        raise InputError(f"--set '{text}': expected RECORD.FIELD=VALUE, as EVIDENCE.needed_nat=50")
    known: dict[str, Any] = {name: found for module in modules() for name, found in records(module)}
    if record not in known:
        raise unknown("record of --set", record, known)
    before = known[record]
    names = [f.name for f in fields(before)]
    if field not in names:
        raise unknown(f"threshold of {record}", field, names)
    after = replace(before, **{field: as_before(text, value, getattr(before, field))})
    for module in modules():
        if getattr(module, record, None) is before:  # its own, or one that another's numbers follow from
            setattr(module, record, after)


def as_before(text: str, value: str, before: object) -> object:
    """Return a typed value as the kind that a threshold has; `InputError` for another kind."""
    try:
        found = ast.literal_eval(value.strip())
    except (ValueError, SyntaxError):
        found = None
    if isinstance(before, float) and type(found) is int:
        found = float(found)
    if type(found) is not type(before):
        raise InputError(f"--set '{text}': expected a value like {before!r}, got '{value.strip()}'")
    return found


@contextmanager
def told(say: Callable[[str], None]) -> Iterator[None]:
    """Say what becomes of every proposal of the search, and of each of its tests; for the block it opens."""
    from imubench.diagnosis.search import loop

    decided, outcome = loop.decided, loop.outcome
    tests: list[str] = []

    def outcome_told(test: "Test", gain: "Gain | None") -> "tuple[bool, Gain | None]":
        met: float | None = None
        asked = test
        if isinstance(test, loop.Above):
            met = test.measure()
            asked = replace(test, measure=lambda: met)
        passed, gain = outcome(asked, gain)
        tests.append(f"    {'passed' if passed else 'failed'}: {in_words(test, met, gain)}")
        return passed, gain

    def decided_told(proposal: "Proposal", state: "SearchState") -> "Answer":
        tests.clear()
        answer = decided(proposal, state)
        if proposal.tests:
            say(f"  {'taken' if answer.accepted else 'refused'}: {proposal.what}")
            for line in tests:
                say(line)
        return answer

    loop.decided, loop.outcome = decided_told, outcome_told
    try:
        yield
    finally:
        loop.decided, loop.outcome = decided, outcome


def in_words(test: "Test", met: float | None, gain: "Gain | None") -> str:
    """Return what a test asked, where it stands in the code, and what it met."""
    from imubench.diagnosis.search.moves.move import Above, Foretells, Holds

    if isinstance(test, Above):
        return f"{met:.4g} nat, needed {test.bound:.4g} ({where(test.measure)})"
    if isinstance(test, Foretells) and gain is not None:
        noted = ", noted only" if test.anyway else ""
        return (
            f"{gain.value:.4g} nat on left-out data, 95 % {gain.low:.4g} to {gain.high:.4g}{noted} ({where(test.gain)})"
        )
    return f"a condition ({where(test.condition if isinstance(test, Holds) else test.gain)})"


def where(asked: Callable[[], object]) -> str:
    """Return the file and line that a test was written in."""
    code = getattr(inspect.unwrap(asked), "__code__", None)
    return f"{'/'.join(Path(code.co_filename).parts[-2:])}:{code.co_firstlineno}" if code else "elsewhere"


def explain(recording: Path, without: Sequence[str] = ()) -> Iterator[str]:
    """Diagnose a recording without some rules; yield what it says, what was tried in vain, and which rules mattered."""
    from imubench.diagnosis.pipeline import diagnose
    from imubench.diagnosis.rules import RULES, Rules
    from imubench.format1 import read

    rules = Rules(frozenset(without))
    lines: list[str] = []
    with told(lines.append):
        diagnosis, evidence = diagnose(read(recording)[0], rules=rules)
    yield f"verdict: {diagnosis.verdict}"
    yield from (f"  {f.effect} at {f.at}, {f.confidence:.2f} sure" for f in diagnosis.findings)
    yield "proposals of the search, in their order, and their tests up to the first that failed:"
    yield from lines
    yield "tried and not taken (docs/diagnosis-output.md says what the number is):"
    yield from (f"  {r.effect} at {r.at}: {r.heldout_gain:.4g} nat" for r in diagnosis.rejected)
    yield "rules that changed something:"
    yield from (f"  {name} ({times}): {RULES[name]}" for name, times in evidence.fired.items())


def main(words: Sequence[str]) -> int:
    """Print why a recording's diagnosis says what it says."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.why", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("recording", type=Path, metavar="RECORDING")
    parser.add_argument("--set", action="append", default=[], metavar="RECORD.FIELD=VALUE", help="another threshold")
    parser.add_argument("--without", action="append", default=[], metavar="RULE", help="a rule to leave out")
    asked = parser.parse_args(words)
    try:
        for text in asked.set:
            set_threshold(text)
        for line in explain(asked.recording, asked.without):
            print(line, flush=True)
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
