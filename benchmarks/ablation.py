"""What each rule of the diagnosis is good for: recordings diagnosed with it and without.

    python -m benchmarks.ablation FOLDER OUT [--but RULE,RULE]

`FOLDER` holds recordings in format 1, each at `NAME/` or `NAME/recording/`. What is true of one is read from
`NAME/truth.json` (`{"effects": [{"effect", "at"}]}`), or from the `score.json` of `imubench run`. Each recording is
diagnosed once with all rules. Until a rule first changes something, a diagnosis without it is the same one: so it is
done a second time, and where a rule first changed something a copy of the process goes on without it. Every diagnosis
is written to `OUT` when it is done: the same command goes on where it was ended. Diagnoses of other code are made
again. The table is printed at the end, or where it was stopped by Ctrl-C. Rules named by `--but` are not left out.

`python -m benchmarks ablation` prints what is in `IMUBENCH_ABLATION`, an `OUT`.
"""

import argparse
import dataclasses
import os
import sys
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from benchmarks.table import Row
from imubench.answers import write_json
from imubench.checks.versions import code_key
from imubench.diagnosis.pipeline import diagnose
from imubench.diagnosis.result import Diagnosis, Finding
from imubench.diagnosis.rules import RULES, RuleUse, known
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


@dataclasses.dataclass(frozen=True)
class Watched(RuleUse):
    """All rules, with how often each had been asked when it first changed something."""

    asked: Counter[str] = dataclasses.field(default_factory=Counter)
    first: dict[str, int] = dataclasses.field(default_factory=dict)

    def on(self, name: str) -> bool:
        """Return whether a rule may be applied, and count the question."""
        self.asked[name] += 1
        return super().on(name)

    def fires(self, name: str) -> None:
        """Note that a rule has changed something."""
        self.first.setdefault(name, self.asked[name])
        super().fires(name)


@dataclasses.dataclass(frozen=True)
class Branching(RuleUse):
    """All rules; where one first changes something, a copy of the process may go on without it."""

    at: Mapping[str, int] = dataclasses.field(default_factory=dict)  # rule -> the question at which it first fires
    branch: Callable[[str], bool] = lambda _: False  # whether this is the copy that goes on without a rule
    asked: Counter[str] = dataclasses.field(default_factory=Counter)
    without: list[str] = dataclasses.field(default_factory=list)  # the rule that this copy does without

    def on(self, name: str) -> bool:
        """Return whether a rule may be applied; once a copy does without one, no other is left out in it."""
        self.asked[name] += 1
        if not self.without and self.at.get(name) == self.asked[name] and self.branch(name):
            self.without.append(name)
        return super().on(name) and name not in self.without


def as_kept(
    d: Diagnosis, fired: Mapping[str, int], effects: Sequence[Mapping[str, Any]] | None, first: Mapping[str, int]
) -> dict[str, Any]:
    """Return what is kept of a diagnosis: what it says, what that is worth, which rules changed something, and when."""
    return {
        "code": code_key(CODE),
        "said": repr(dataclasses.replace(d, seconds=0.0)),
        "findings": [f"{f.effect} at {f.at} ({f.confidence:.2f})" for f in d.findings],
        "verdict": d.verdict,
        "credit": None if effects is None else credit(d.findings, effects),
        "seconds": d.seconds,
        "fired": dict(fired),
        "first": dict(first),
    }


def kept(path: Path) -> dict[str, Any] | None:
    """Return what is kept of a diagnosis by this code; None where there is none."""
    if not path.is_file():
        return None
    found = load_table(path)
    return found if found.get("code") == code_key(CODE) else None


def with_all(recording: Path, truth: Sequence[Mapping[str, Any]] | None, out: Path) -> dict[str, Any]:
    """Return what is kept of a recording's diagnosis by all rules, from `out` or made now and put there."""
    found = kept(out)
    if found is None:
        use = Watched()
        diagnosis, _ = diagnose(read(recording)[0], rules=use)
        found = as_kept(diagnosis, use.fired, truth, use.first)
        out.parent.mkdir(parents=True, exist_ok=True)
        write_json(out, found)
    return found


def without_each(
    recording: Path, truth: Sequence[Mapping[str, Any]] | None, out: Path, at: Mapping[str, int]
) -> Iterator[str]:
    """Diagnose a recording again, and once more from where each of some rules first changed something, without it.

    Args:
        recording: its folder.
        truth: the effects that are true of it.
        out: the folder in which each diagnosis is kept, as `RULE.json`.
        at: how often each rule had been asked when it first changed something.

    Yields:
        The rules whose diagnosis is there now.
    """
    missing = {rule: asked for rule, asked in at.items() if kept(out / f"{rule}.json") is None}
    if not missing:
        return
    use = Branching(at=missing, branch=goes_on_in_a_copy)
    try:
        diagnosis, _ = diagnose(read(recording)[0], rules=use)
        if use.without:
            write_json(out / f"{use.without[0]}.json", as_kept(diagnosis, use.fired, truth, {}))
    finally:
        if use.without:
            os._exit(0)  # whatever comes after is the first process's
    yield from (rule for rule in missing if kept(out / f"{rule}.json") is not None)


def goes_on_in_a_copy(_: str) -> bool:
    """Return whether this is the copy of the process, which is made now; otherwise wait until it has ended."""
    copy = os.fork()
    if copy:
        os.waitpid(copy, 0)
    return copy == 0


def work(folder: Path, out: Path, but: Collection[str] = ()) -> Iterator[str]:
    """Do what is not done yet; yield a line after every diagnosis."""
    for name, recording in recordings(folder):
        truth = truth_of(folder / name)
        base = with_all(recording, truth, out / name / f"{WITH_ALL}.json")
        yield f"{name}: {', '.join(base['findings']) or base['verdict']}"
        at = {rule: base["first"][rule] for rule in RULES if rule in base["fired"] and rule not in but}
        for rule in without_each(recording, truth, out / name, at):
            other = kept(out / name / f"{rule}.json") or {}
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
    parser = argparse.ArgumentParser(prog="python -m benchmarks.ablation", description=__doc__)
    parser.add_argument("folder", type=Path, metavar="FOLDER")
    parser.add_argument("out", type=Path, metavar="OUT")
    parser.add_argument("--but", default="", metavar="RULE,RULE", help="rules that are not left out")
    asked = parser.parse_args(words)
    asked.out.mkdir(parents=True, exist_ok=True)
    try:
        for line in work(asked.folder, asked.out, [known(name) for name in asked.but.split(",") if name]):
            print(line, file=sys.stderr, flush=True)
    except KeyboardInterrupt:
        print("stopped; the same command goes on", file=sys.stderr)
    print(table(tallies(asked.out)))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
