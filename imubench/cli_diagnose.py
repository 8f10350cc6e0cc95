"""`imubench diagnose`: what is done while it runs, then the verdict, where, and what was found."""

from math import inf
from pathlib import Path

from rich.table import Table

from imubench.diagnosis.on_disk import REPORT, diagnose_on_disk
from imubench.diagnosis.report import words
from imubench.diagnosis.report.numbers import rows, shown
from imubench.diagnosis.result import Diagnosis
from imubench.errors import InputError
from imubench.progress import on_console
from imubench.terminal import Terminal

COLOURS = {"good": "green", "part": "yellow", "bad": "red"}


def run(
    recording: Path,
    out: Path,
    time_limit: float,
    tolerance: str,
    baseline: Path | None,
    console: Terminal,
    errors: Terminal,
) -> None:
    """Diagnose a recording into `out` within `time_limit` s of processor time and print what came out.

    Raises:
        InputError: for a tolerance that is none, a baseline of other sensors, and where the report could not be drawn.
    """
    done = diagnose_on_disk(recording, out, on_console(errors), time_limit, read_tolerance(tolerance), baseline)
    print_diagnosis(done.diagnosis, done.evidence.span, console)
    shown = f"; open {out / REPORT}" if not done.missing else ""
    console.say(f"written: {out}{shown}")
    if done.missing:
        raise InputError(done.missing)


def read_tolerance(text: str) -> tuple[float, float]:
    """Return the tolerance DEG,MM; `InputError` unless both are finite numbers >= 0."""
    try:
        deg, mm = (float(part) for part in text.split(","))
    except ValueError:
        raise InputError(f"--tolerance: expected DEG,MM such as 0.5,5, got '{text}'") from None
    if not (0 <= deg < inf and 0 <= mm < inf):
        raise InputError(f"--tolerance: expected two finite numbers >= 0, got '{text}'")
    return deg, mm


def print_diagnosis(d: Diagnosis, span: tuple[float, float], console: Terminal) -> None:
    """Print the verdict, the misfit, where it is and what was found."""
    colour = COLOURS[words.VERDICTS[d.verdict]]
    console.say(d.verdict, f"bold {colour}", f": {words.headline(d)}")
    if d.findings:
        console.say("alarm" if d.alarm else "no alarm", "bold red" if d.alarm else "bold green", f": {words.alarm(d)}")
    if d.baseline is not None:
        console.say(words.baseline(d.baseline))
    if d.stopped:
        console.say(words.stopped(d))
    if d.fitted:
        before, after = d.misfit
        change = f"{before:.2f}" if before == after else f"{before:.2f} as declared, {after:.2f} with what was found"
        console.print(f"misfit, 1 is only sensor noise: {change}")
    for text in words.places(d, span):
        console.say(f"  {text}")
    unit = d.fit.reference.unit
    for name, value in d.fit.reference.before.items():
        was, is_now = (shown(x, unit.split()[0])[0] for x in (value, d.fit.reference.after[name]))
        change = f"{was:.2f}" if was == is_now else f"{was:.2f} as declared, {is_now:.2f} with what was found"
        console.print(f"{words.MEASURED.get(name, name)} against the reference (deg RMS): {change}")
    named = [f for f in d.findings if f.named and f.material]
    if named:
        table = Table(box=None, header_style="bold", padding=(0, 2, 0, 0))
        for column in ("finding", "sure", "parameter", "value", "95 % interval", "unit"):
            table.add_column(column, justify="right" if column in ("value", "95 % interval") else "left")
        for finding in named:
            body = [row for name, p in finding.parameters.items() for row in rows(name, p)] or [("", "", "", "")]
            for i, row in enumerate(body):
                first = (f"{finding.effect} at {finding.at}", words.percent(finding.confidence)) if i == 0 else ("", "")
                table.add_row(*first, *row)
        console.print(table)
    for finding in [f for f in d.findings if f.material]:
        console.say(f"  {finding.effect} at {finding.at} moves {words.moved(finding)}")
    small = [f for f in d.findings if not f.material]
    if small:
        console.say(f"immaterial, below {words.tolerance(d)}:")
    for finding in small:
        sure = words.percent(finding.confidence)
        console.say(f"  {finding.effect} at {finding.at} ({sure} sure) moves {words.moved(finding)}")
    for doubt in d.doubts:
        console.say(f"  not to be trusted: {doubt.of}: {doubt.why}")
    for unseen in d.unseen if d.fitted else ():  # else the headline says it
        console.say(f"  to see {unseen.what}: {unseen.motion}")
