"""The tables of docs/real.md and RESULTS.md: one row a case, and what all of them add up to."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from benchmarks.real.axes import ESTIMATORS
from benchmarks.real.facts import Disturbance, Fact, Name
from benchmarks.real.repeat import Repeated
from benchmarks.real.scoring import AxisError, CaseScore, degrees
from benchmarks.real.steps import NOT_RUN
from benchmarks.table import Row
from imubench.arrays import Array
from imubench.diagnosis.result import Pair

COLUMNS = (
    "case",
    "known to be there",
    "verdict",
    "named",
    "located",
    "silent",
    "said besides",
    "wrong but explained",
    "held out",
    "hinge angle, deg",
    *(f"axis by {name}, deg" for name in ESTIMATORS),
    "processor time, s",
    "GB",
)


@dataclass(frozen=True)
class Line:
    """One case in the table."""

    name: str
    known: str
    failed: str = ""  # why there is no score
    score: CaseScore | None = None
    seconds: float = 0.0  # of processor time, of the diagnosis
    memory: float = 0.0  # GB


@dataclass(frozen=True)
class Halves:
    """A recording whose halves were diagnosed each."""

    name: str
    findings: Sequence[Repeated]
    raw: dict[str, Array] = field(default_factory=dict)  # rad (2,): by how much the axes differ between the halves
    corrected: dict[str, Array] = field(default_factory=dict)


def cases_table(lines: Sequence[Line]) -> str:
    """Return the table of the cases that were run; one without a score says why. The others are named behind it."""
    rest = [line.name for line in lines if line.failed == NOT_RUN]
    lines = [line for line in lines if line.failed != NOT_RUN]
    rows = [list(COLUMNS), [":--" if i < 3 else "--:" for i in range(len(COLUMNS))]]
    for line in lines:
        s = line.score
        if s is None:
            rows.append([line.name, line.known, f"**{line.failed}**", *["-"] * (len(COLUMNS) - 3)])
            continue
        rows.append(
            [
                line.name,
                line.known,
                s.verdict + (" (stopped)" if s.stopped else ""),
                *(_yes(x) for x in (s.named, s.located, s.silent)),
                "; ".join(s.besides) or "-",
                f"**{'; '.join(s.wrong)}**" if s.wrong else "-",
                "-" if s.heldout is None else change(s.heldout),
                "-" if s.angle is None else change((np.degrees(s.angle[0]), np.degrees(s.angle[1]))),
                *(axis(s.axes[name]) if name in s.axes else "-" for name in ESTIMATORS),
                f"{line.seconds:.0f}",
                f"{line.memory:.2f}",
            ]
        )
    table = "\n".join("| " + " | ".join(_cell(c) for c in row) + " |" for row in rows) + "\n"
    return table + (f"\nNot run yet, {len(rest)} cases: {', '.join(rest)}.\n" if rest else "")


def halves_table(halves: Sequence[Halves]) -> str:
    """Return the table of what one half says and the other confirms, and of how far their axes differ."""
    out = [
        "| recording | confirmed by the other half | not confirmed | axes between halves, deg |",
        "|:--|--:|:--|:--|",
    ]
    for h in halves:
        kept = sum(not f.why for f in h.findings)
        broken = "; ".join(f"{f.finding}: {f.why}" for f in h.findings if f.why) or "-"
        axes = "; ".join(
            f"{name} {degrees(off)}" + (f" to {degrees(h.corrected[name])}" if name in h.corrected else "")
            for name, off in h.raw.items()
        )
        out.append(f"| {h.name} | {kept} of {len(h.findings)} | {_cell(broken)} | {axes or '-'} |")
    return "\n".join(out) + "\n"


def facts_table(known: Sequence[Fact]) -> str:
    """Return the table of what is known of each recording; the first row whose pattern fits a case counts."""
    out = ["| cases | known | how | named by | may be there, too | all that matters |", "|:--|:--|:--|:--|:--|:--|"]
    for fact in known:
        there = "; ".join(f"{t.what}: {names_in_words(t.names, ' or ')}{band(t)}" for t in fact.there)
        may, whole = names_in_words(fact.may, ", "), "yes" if fact.complete else "no"
        cells = (f"`{fact.cases}`", fact.known, fact.source, there or "-", may or "-", whole)
        out.append("| " + " | ".join(_cell(c) for c in cells) + " |")
    return "\n".join(out) + "\n"


def names_in_words(names: Sequence[Name], between: str) -> str:
    """Return effects with their places."""
    return between.join(f"{effect} at {at}" for effect, at in names)


def band(there: Disturbance) -> str:
    """Return where an unknown has to be so that it locates a disturbance, behind what names it."""
    return f", or an unknown at {there.at}" + (f" from {there.above_hz:g} Hz or more on" if there.above_hz else "")


def rows_table(rows: Sequence[Row]) -> str:
    """Return the table of what is required."""
    body = [f"| {r.what} | {r.ours} | {r.required} | {'yes' if r.met else '**no**'} |" for r in rows]
    return "\n".join(["| what | ours | required | met |", "|:--|--:|--:|--:|", *body]) + "\n"


def change(pair: Pair) -> str:
    """Return two numbers, before and after."""
    return f"{pair[0]:.2f} to {pair[1]:.2f}"


def axis(pair: tuple[AxisError, AxisError]) -> str:
    """Return the deviations at imu1 / imu2, raw and with the findings taken out; a star where it did not converge."""
    cells = ("none" if e.off is None else degrees(e.off) + ("" if e.converged else "*") for e in pair)
    return " to ".join(cells)


def replaced(text: str, heading: str, body: str) -> str:
    """Return a Markdown text whose section of that heading holds `body`; it comes last where there was none.

    The section ends at the next heading of its level or a higher one.
    """
    level = len(heading) - len(heading.lstrip("#"))
    found = re.search(rf"^{re.escape(heading)}$", text, re.MULTILINE)
    if found is None:
        return f"{text.rstrip()}\n\n{heading}\n\n{body.strip()}\n"
    after = re.search(rf"^#{{1,{level}}} ", text[found.end() :], re.MULTILINE)
    rest = text[found.end() + after.start() :] if after else ""
    return f"{text[: found.end()]}\n\n{body.strip()}\n" + (f"\n{rest}" if rest else "")


def _yes(answer: bool | None) -> str:
    return "-" if answer is None else "yes" if answer else "no"


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("\n", " ")
