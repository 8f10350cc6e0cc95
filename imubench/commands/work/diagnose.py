"""`imubench diagnose`: what is done while it runs, then the verdict, where, what was found, and what to do next."""

from math import inf
from pathlib import Path

from rich.table import Table

from imubench.diagnosis.config.shared import CONFIDENCE
from imubench.diagnosis.evidence import Evidence
from imubench.diagnosis.on_disk import REPORT, STEP_BEGINNINGS, diagnose_on_disk
from imubench.diagnosis.report import Paths, headline, words
from imubench.diagnosis.report.first_screen import command_lines, consequence, ordered, steps
from imubench.diagnosis.report.numbers import rows, size
from imubench.diagnosis.result import Diagnosis, Finding
from imubench.diagnosis.result_file import FILE_NAME
from imubench.errors import InputError
from imubench.progress import in_stages
from imubench.sources import Source
from imubench.terminal import Terminal

COLOURS = {"good": "green", "part": "yellow", "bad": "red"}
CHANNELS = 3  # that differ most, in a terminal's lines


def run(
    recording: Source,
    out: Path,
    time_limit: float,
    tolerance: str,
    baseline: Source | None,
    console: Terminal,
    errors: Terminal,
) -> None:
    """Diagnose a recording into `out` within `time_limit` s of processor time and print what came out.

    Raises:
        InputError: for a tolerance that is none, and a baseline of other sensors.
    """
    limits = read_tolerance(tolerance)
    earlier = None if baseline is None else Path(baseline)
    known = earlier is None or earlier.is_file() or (earlier / FILE_NAME).is_file()
    plan = STEP_BEGINNINGS if known else (STEP_BEGINNINGS[0], *STEP_BEGINNINGS, *STEP_BEGINNINGS[1:])
    done = diagnose_on_disk(Path(recording), out, in_stages(errors, plan), time_limit, limits, earlier)
    print_diagnosis(done.diagnosis, done.evidence, console, Paths(str(recording), str(out)))
    console.say(f"written: {out}; open {out / REPORT}")


def read_tolerance(text: str) -> tuple[float, float]:
    """Return the tolerance DEG,MM; `InputError` unless both are finite numbers >= 0."""
    try:
        deg, mm = (float(part) for part in text.split(","))
    except ValueError:
        raise InputError(f"--tolerance: expected DEG,MM such as 0.5,5, got '{text}'") from None
    if not (0 <= deg < inf and 0 <= mm < inf):
        raise InputError(f"--tolerance: expected two finite numbers >= 0, got '{text}'")
    return deg, mm


def print_diagnosis(d: Diagnosis, evidence: Evidence, console: Terminal, paths: Paths | None = None) -> None:
    """Print the verdict, how far the simulations are off, where, what was found, and what to type next."""
    colour = COLOURS[words.VERDICT_LOOKS[d.verdict]]
    console.say(d.verdict, f"bold {colour}", f": {headline.headline(d)}")
    if d.findings:
        console.say("alarm" if d.alarm else "no alarm", "bold red" if d.alarm else "bold green", f": {words.alarm(d)}")
    if d.baseline is not None:
        console.say(words.baseline(d.baseline))
    print_fit(d, evidence, console)
    for i in ordered(d, True) if d.fitted else ():
        compared = evidence.comparisons[i] if i < len(evidence.comparisons) else ()
        share = d.findings[i].share
        back = "" if share is None else f" Without it {words.part(share)} of the difference comes back."
        console.say(f"  {consequence(d.findings[i], compared)}{back}")
    print_numbers([d.findings[i] for i in ordered(d, True) if d.findings[i].named], console)
    small = [d.findings[i] for i in ordered(d, False)]
    if small:
        console.say(f"immaterial, below {words.tolerance(d)}:")
    for finding in small:
        sure = words.percent(finding.confidence)
        console.say(f"  {finding.effect} at {finding.at} ({sure} sure) moves {words.moved(finding.moves)}")
    for doubt in d.doubts:
        console.say(f"  not to be trusted: {doubt.of}: {doubt.why}")
    for text in steps(d, evidence):
        console.say(f"next: {text}")
    for line in command_lines(d, evidence, paths or Paths()):
        console.say(f"  {line}")


def print_fit(d: Diagnosis, evidence: Evidence, console: Terminal) -> None:
    """Print by how much the declared model, and the one with what was found, differ from the recording, and where."""
    found = any(f.named and f.confidence >= CONFIDENCE.counts for f in d.findings)
    if d.simulation is not None and d.simulation.channels:
        console.say(f"MuJoCo's simulation, {d.simulation.how}, is off by (RMS):")
        for off in headline.deviations(d.simulation)[:CHANNELS]:
            change = f"{off.before} as declared, {off.after} with what was found" if found else off.before
            console.say(f"  {words.spelled(off.channel)}: {change} ({off.unit}; noise {off.noise})")
    elif d.fitted:
        before, after = (f"{x:.2f}" for x in d.misfit)
        change = before if before == after else f"{before} as declared, {after} with what was found"
        console.say(f"misfit of the fitted motion, 1 is only noise: {change}")
    usual = headline.usual_noise(d, {i.name: i.rate for i in evidence.recording.imus})
    if usual:
        console.say(f"noise not known: {usual}")
    for text in headline.places(d, evidence.span) if d.fitted else ():  # else that is what to do next
        console.say(f"  {text}")
    for name, was, is_now in headline.against_reference(d):
        change = f"{was:.2f}" if was == is_now else f"{was:.2f} as declared, {is_now:.2f} with what was found"
        console.say(f"{name} against the reference (deg RMS): {change}")


def print_numbers(found: list[Finding], console: Terminal) -> None:
    """Print the parameters of findings as a table, and what of them the recording does not show."""
    if not found:
        return
    table = Table(box=None, header_style="bold", padding=(0, 2, 0, 0))
    for column in ("finding", "sure", "parameter", "value", "95 % interval", "unit"):
        table.add_column(column, justify="right" if column in ("value", "95 % interval") else "left")
    for finding in found:
        body = [row for name, p in finding.parameters.items() for row in rows(name, p)] or [("", "", "", "")]
        for i, row in enumerate(body):
            first = (f"{finding.effect} at {finding.at}", words.percent(finding.confidence)) if i == 0 else ("", "")
            table.add_row(*first, *row)
    console.print(table)
    for finding in found:
        for name, p in finding.parameters.items():
            if text := size(name, p):
                console.say(f"  {finding.effect} at {finding.at}: {text}")
        if finding.unseen:
            unseen = words.listed([f"the {text}" for text in finding.unseen])
            console.say(f"  {finding.effect} at {finding.at}: this recording does not show {unseen}")
