"""What a check writes: claims.json for programs, junit.xml for build servers, summary.md for people."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import imubench
from imubench.answers import write_json
from imubench.checks import words
from imubench.checks.baseline import runs_as_dict
from imubench.checks.check import Checked
from imubench.checks.decide import Decision
from imubench.figures import words as figure_words

CLAIMS, JUNIT, SUMMARY = "claims.json", "junit.xml", "summary.md"
ENTITIES = {"<": "&lt;", ">": "&gt;", "|": "&#124;", "&": "&amp;"}
MARKUP = str.maketrans({mark: f"\\{mark}" for mark in "\\`*_[]#"} | ENTITIES)


def write_outputs(done: Sequence[Checked], source: str, folder: Path) -> None:
    """Write what was found about the claims of a file called `source` into a folder."""
    write_json(folder / CLAIMS, claims_content(done, source))
    (folder / JUNIT).write_bytes(junit(done, source))
    (folder / SUMMARY).write_text(summary(done, source), encoding="utf-8")


def claims_content(done: Sequence[Checked], source: str) -> list[dict[str, Any]]:
    """Return the entries of claims.json: one for each claim, and one more where a baseline was compared."""
    return [_entry(one, decision, source) for one in done for decision in one.decisions]


def _entry(one: Checked, decision: Decision, source: str) -> dict[str, Any]:
    claim, beside = one.claim, decision.baseline is not None
    value = decision.measured
    if beside:
        published, bound, unit = 1.0, f"< {1 + claim.margin:g}", "1"
    elif claim.over == "share":
        published, bound, unit = claim.at_least, f">= {claim.at_least:g}", "1"
    else:
        published, bound, unit = claim.bound.value, f"<= {claim.bound}", claim.bound.unit
        value = claim.bound.in_unit(value)
    entry = {
        "name": words.title(decision),
        "claim": words.sentence(decision),
        "source": f"{source}: {claim.name}",
        "published": published,
        "measured": value if math.isfinite(value) else None,
        "unit": unit,
        "bound": bound,
        "verdict": "holds" if decision.verdict == "holds" else "fails",
        "decided": decision.verdict != "undecided",
        "why": "; ".join(text for text in (words.measured(decision), words.troubles(decision)) if text),
        "runs": decision.runs,
        "runs_without_the_figure": len(decision.missing),
        "false_failure_rate": _rate(claim.confidence),
        "missed_rate": _rate(decision.power),
        "broken": f"ratio {1 + claim.margin:g}" if beside else claim.broken,
        "estimator": claim.named,
    }
    return entry if beside else {**entry, **runs_as_dict(claim, one.first, one.errors)}


def _rate(sure: float) -> float:
    return round(1.0 - sure, 12)  # 0.01 and not 0.010000000000000009


def junit(done: Sequence[Checked], source: str) -> bytes:
    """Return a JUnit file as pytest writes them: a test case for each decision, with a failure where it is not kept."""
    decisions = [d for one in done for d in one.decisions]
    failed = sum(d.verdict != "holds" for d in decisions)
    took = f"{sum(one.seconds for one in done):.3f}"
    counts = {"errors": "0", "failures": str(failed), "skipped": "0", "tests": str(len(decisions)), "time": took}
    suites = ElementTree.Element("testsuites", name="imubench check")
    suite = ElementTree.SubElement(suites, "testsuite", {"name": source, **counts})
    for checked, d in ((one, d) for one in done for d in one.decisions):
        time = f"{checked.seconds / len(checked.decisions):.3f}"
        case = ElementTree.SubElement(suite, "testcase", classname=source, name=words.title(d), time=time)
        if d.verdict != "holds":
            message = f"{words.sentence(d)}; {words.measured(d)}"
            ElementTree.SubElement(case, "failure", message=message).text = words.paragraph(d)
        ElementTree.SubElement(case, "system-out").text = f"{words.measured(d)}; {words.rates(d)}"
    ElementTree.indent(suites)
    return ElementTree.tostring(suites, encoding="utf-8", xml_declaration=True) + b"\n"


def summary(done: Sequence[Checked], source: str) -> str:
    """Return the Markdown summary: the finding, a row for each decision, and how sure that is."""
    decisions = [d for one in done for d in one.decisions]
    rows = [
        f"| {_verdict(d)} | {_cell(words.title(d))} | {_cell(words.sentence(d))} | {_cell(words.measured(d))} |"
        for d in sorted(decisions, key=lambda d: d.verdict == "holds")
    ]
    notes = [f"- {_cell(words.title(d))}: {_cell(words.troubles(d))}" for d in decisions if words.troubles(d)]
    figures = dict.fromkeys(d.claim.figure for d in decisions)
    sure = list(dict.fromkeys(f"- {_cell(words.title(d))}: {words.rates(d)}" for d in decisions))
    text = [
        f"## imubench check: {_cell(words.finding(done))}",
        "",
        "| verdict | claim | what is claimed | what came out |",
        "|---|---|---|---|",
        *rows,
        "",
        *([*notes, ""] if notes else []),
        "What is measured:",
        "",
        *(f"- {_cell(figure)}: {_cell(figure_words(figure))}" for figure in figures),
        "",
        "How sure:",
        "",
        *sure,
        "",
        f"{source}, imubench {imubench.__version__}; runs stop as soon as they decide.",
    ]
    return "\n".join(text) + "\n"


def _verdict(decision: Decision) -> str:
    return "holds" if decision.verdict == "holds" else f"**{decision.verdict}**"


def _cell(text: str) -> str:
    """Return text as it stands in a table: nothing in it is markup."""
    return text.translate(MARKUP)
