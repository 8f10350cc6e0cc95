"""Why a diagnosis says what it says: what the search proposed, which tests each proposal met, and by how much.

    python -m benchmarks.why RECORDING [--set RECORD.FIELD=VALUE ...] [--without RULE ...]

`RECORDING` is a folder in format 1. `--set` gives a threshold of docs/thresholds.md another value, in this run alone;
`--without` leaves out a rule of `imubench list rules`. What is printed can be compared: run it with and without, and
`diff` the two.
"""

import argparse
import ast
import sys
from collections.abc import Iterator, Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from imubench.errors import InputError, unknown
from imubench.threshold_table import modules, records

if TYPE_CHECKING:
    from imubench.diagnosis.rules import Decision

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


def lines_of(decisions: Sequence["Decision"]) -> Iterator[str]:
    """Yield what became of every proposal of the search, and of each of its tests."""
    for decision in decisions:
        yield f"  {'taken' if decision.accepted else 'refused'}: {decision.what} (by the rule {decision.rule})"
        for test in decision.tests:
            where = f" ({test.place})" if test.place else ""
            yield f"    {'passed' if test.passed else 'failed'}: {test.met}{where}"


def explain(recording: Path, without: Sequence[str] = ()) -> Iterator[str]:
    """Diagnose a recording without some rules; yield what it says, what was tried in vain, and which rules mattered."""
    from imubench.diagnosis.pipeline import diagnose
    from imubench.diagnosis.rules import RULES, Rules
    from imubench.format1 import read

    diagnosis, evidence = diagnose(read(recording)[0], rules=Rules(frozenset(without)))
    yield f"verdict: {diagnosis.verdict}"
    yield from (f"  {f.effect} at {f.at}, {f.confidence:.2f} sure" for f in diagnosis.findings)
    yield "proposals of the search, in their order, and their tests up to the first that failed:"
    yield from lines_of(evidence.decisions)
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
