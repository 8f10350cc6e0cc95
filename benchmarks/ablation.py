"""What each rule of the diagnosis is good for: recordings diagnosed with it and without.

    python -m benchmarks.ablation FOLDER OUT

`FOLDER` holds recordings in format 1, each at `NAME/` or `NAME/recording/`. What is true of one is read from
`NAME/truth.json` (`{"effects": [{"effect", "at"}]}`), or from the `score.json` of `imubench run`. Each recording is
diagnosed once with all rules; then once more without each rule that changed something in it, and only those. Every
diagnosis is written to `OUT` when it is done: the same command goes on where it was ended. Diagnoses of other code are
made again. The table is printed at the end, or where it was stopped by Ctrl-C.

`python -m benchmarks ablation` prints what is in `IMUBENCH_ABLATION`, an `OUT`.
"""

import dataclasses
import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from benchmarks.table import Row
from imubench.answers import write_json
from imubench.checks.versions import code_key
from imubench.diagnosis.pipeline import diagnose
from imubench.diagnosis.result import Diagnosis, Finding
from imubench.diagnosis.rules import RULES, Rules
from imubench.errors import InputError
from imubench.format1 import read
from imubench.inputs.json import load_table

SAID = 0.5  # confidence from which a finding counts as said, as in the blind trials
EQUAL = 0.5  # of a name, what it is worth among the equals of another finding: there are two to choose from
SAME = 0.02  # of a name: confidences that differ by less are one
WITH_ALL = "all"
CODE = ("imubench.diagnosis", "imubench.effects")  # what decides what a diagnosis says
HEAD = ("rule", "fired in", "changed", "better with it", "worse with it")


@dataclasses.dataclass(frozen=True)
class Tally:
    """How many recordings a rule matters for."""

    rule: str
    fired: int = 0
    asked: int = 0  # of these diagnosed without it
    changed: int = 0
    better: int = 0  # with the rule, by the recording's truth
    worse: int = 0


def recordings(folder: Path) -> Iterator[tuple[str, Path]]:
    """Yield the recordings of a folder by name, each with its own folder in format 1."""
    for path in sorted(p for p in folder.iterdir() if p.is_dir()):
        inner = next((p for p in (path / "recording", path) if (p / "recording.toml").is_file()), None)
        if inner is not None:
            yield path.name, inner


def truth_of(folder: Path) -> list[Mapping[str, Any]] | None:
    """Return the effects that are true of a recording, from beside it; None where nobody says."""
    for name, keys in (("truth.json", ("effects",)), ("score.json", ("changes", "effects"))):
        if (folder / name).is_file():
            table: Any = load_table(folder / name)
            for key in keys:
                table = table.get(key, {}) if isinstance(table, dict) else {}
            return list(table) if isinstance(table, list) else []
    return None


def credit(findings: Sequence[Finding], effects: Sequence[Mapping[str, Any]]) -> float:
    """Return what findings are worth: a name for each effect, less the confidence of each name that is not there.

    An effect that the table of effects lacks (`"inside": false`) is found by something without a name at its place.
    """
    said = [f for f in findings if f.confidence >= SAID]
    true = {(e["effect"], e["at"]) for e in effects if e.get("inside", True)}
    strange = {e["at"] for e in effects if not e.get("inside", True)}
    direct = {(f.effect, f.at) for f in said}
    equal = {(r.effect, r.at) for f in said for r in f.equivalent}
    worth = sum(1.0 if e in direct else EQUAL if e in equal else 0.0 for e in true)
    worth += len(strange & {f.at for f in said if not f.named})
    for f in said:
        right = (f.effect, f.at) in true or any((r.effect, r.at) in true for r in f.equivalent)
        if not (right or (not f.named and f.at in strange)):
            worth -= f.confidence
    return worth


def as_kept(d: Diagnosis, fired: Mapping[str, int], effects: Sequence[Mapping[str, Any]] | None) -> dict[str, Any]:
    """Return what is kept of a diagnosis: what it says, what that is worth, which rules changed something."""
    return {
        "code": code_key(CODE),
        "said": repr(dataclasses.replace(d, seconds=0.0)),
        "findings": [f"{f.effect} at {f.at} ({f.confidence:.2f})" for f in d.findings],
        "verdict": d.verdict,
        "credit": None if effects is None else credit(d.findings, effects),
        "seconds": d.seconds,
        "fired": dict(fired),
    }


def kept(path: Path) -> dict[str, Any] | None:
    """Return what is kept of a diagnosis by this code; None where there is none."""
    if not path.is_file():
        return None
    found = load_table(path)
    return found if found.get("code") == code_key(CODE) else None


def once(recording: Path, truth: Sequence[Mapping[str, Any]] | None, out: Path, rules: Rules) -> dict[str, Any]:
    """Return what is kept of a recording's diagnosis by some rules, from `out` or made now and put there."""
    found = kept(out)
    if found is None:
        diagnosis, evidence = diagnose(read(recording)[0], rules=rules)
        found = as_kept(diagnosis, evidence.fired, truth)
        out.parent.mkdir(parents=True, exist_ok=True)
        write_json(out, found)
    return found


def work(folder: Path, out: Path) -> Iterator[str]:
    """Do what is not done yet; yield a line after every diagnosis."""
    for name, recording in recordings(folder):
        truth = truth_of(folder / name)
        base = once(recording, truth, out / name / f"{WITH_ALL}.json", Rules())
        yield f"{name}: {', '.join(base['findings']) or base['verdict']}"
        for rule in [r for r in RULES if r in base["fired"]]:
            other = once(recording, truth, out / name / f"{rule}.json", Rules(frozenset({rule})))
            yield f"{name} without {rule}: {', '.join(other['findings']) or other['verdict']}"


def tallies(out: Path) -> list[Tally]:
    """Return every rule over the diagnoses in a folder."""
    found = {name: Tally(name) for name in RULES}
    for folder in sorted(p for p in out.iterdir() if p.is_dir()):
        base = kept(folder / f"{WITH_ALL}.json")
        if base is None:
            continue
        for rule in [r for r in RULES if r in base["fired"]]:
            found[rule] = compared(found[rule], base, kept(folder / f"{rule}.json"))
    return list(found.values())


def compared(tally: Tally, base: Mapping[str, Any], other: Mapping[str, Any] | None) -> Tally:
    """Return a rule's tally with one recording more, in which it changed something."""
    tally = dataclasses.replace(tally, fired=tally.fired + 1)
    if other is None:
        return tally
    gain = 0.0 if base["credit"] is None else base["credit"] - other["credit"]
    return dataclasses.replace(
        tally,
        asked=tally.asked + 1,
        changed=tally.changed + (base["said"] != other["said"]),
        better=tally.better + (gain > SAME),
        worse=tally.worse + (gain < -SAME),
    )


def table(found: Sequence[Tally]) -> str:
    """Return the tallies as a Markdown table, rules that never fired last."""
    rows = [
        (t.rule, f"{t.fired}", f"{t.changed} of {t.asked}", f"{t.better}", f"{t.worse}")
        for t in sorted(found, key=lambda t: -t.fired)
    ]
    return "\n".join(f"| {' | '.join(row)} |" for row in (HEAD, ("---", *["---:"] * 4), *rows))


def run() -> list[Row]:
    """Return a row for each rule that fired, from the folder that `IMUBENCH_ABLATION` names.

    Raises:
        InputError: where that is no folder.
    """
    folder = os.environ.get("IMUBENCH_ABLATION", "")
    if not folder or not Path(folder).is_dir():
        raise InputError(f"IMUBENCH_ABLATION: expected an OUT of `python -m benchmarks.ablation`, got '{folder}'")
    return [
        Row(
            f"rule {t.rule}: fired in {t.fired}, changed {t.changed} of {t.asked}",
            f"better in {t.better}",
            f"worse in {t.worse}",
            "-",
            "not worse more often than better",
            t.worse <= t.better,
        )
        for t in tallies(Path(folder))
        if t.fired
    ]


def main(words: Sequence[str]) -> int:
    """Diagnose what is not done yet, and print the table."""
    if len(words) != 2:
        print("usage: python -m benchmarks.ablation FOLDER OUT", file=sys.stderr)
        return 2
    folder, out = map(Path, words)
    out.mkdir(parents=True, exist_ok=True)
    try:
        for line in work(folder, out):
            print(line, file=sys.stderr, flush=True)
    except KeyboardInterrupt:
        print("stopped; the same command goes on", file=sys.stderr)
    print(table(tallies(out)))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
