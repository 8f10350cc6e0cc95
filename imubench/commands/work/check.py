"""`imubench check`: a bar of the runs, the finding, a line for each claim; exit code 1 where one does not hold."""

import os
from pathlib import Path

from imubench.answers import write_json
from imubench.atomic import atomic_directory, atomic_file, check_apart
from imubench.checks import words
from imubench.checks.baseline import read_baselines
from imubench.checks.check import Checked, check
from imubench.checks.claim import Claim, load_claims
from imubench.checks.outputs import claims_content, summary, write_outputs
from imubench.checks.runs import running
from imubench.errors import InputError, unknown
from imubench.progress import bars
from imubench.signals import promising
from imubench.terminal import Terminal
from imubench.workers import cores

COLOURS = {"holds": "green", "fails": "red", "undecided": "yellow"}
BASELINE_RUNS = 400
"""Runs of a baseline: enough in nine checks of ten, where a method as good has errors that differ by a factor of 1.7 on
one seed, which takes 183 runs on average (benchmarks, claim_checks)."""
STEP_SUMMARY = "GITHUB_STEP_SUMMARY"
"""Names the file whose Markdown GitHub shows for a step of a workflow."""


def run(
    path: Path,
    out: Path,
    estimator: str | None,
    only: list[str],
    against: Path | None,
    save_baseline: Path | None,
    least: int | None,
    seed: int,
    workers: int | None,
    console: Terminal,
    errors: Terminal,
) -> int:
    """Check the claims of a file into `out`, print what came out, and return the exit code."""
    claims = _chosen(load_claims(path, estimator), only)
    baselines = {} if against is None else read_baselines(against, claims)
    if save_baseline is not None:
        check_apart(save_baseline, [path])
    if least is None:
        least = 0 if save_baseline is None else BASELINE_RUNS
    inputs = [path, *([] if against is None else [against])]
    with (
        promising("runs that are done are kept: the same command goes on from there"),
        atomic_directory(out, inputs) as folder,
    ):
        with bars(errors) as report, running(workers or cores(), out) as runs:
            done = check(claims, runs, seed, baselines, least, report)
        write_outputs(done, path.name, folder)
    if save_baseline is not None:
        with atomic_file(save_baseline) as partial:
            write_json(partial, claims_content(done, path.name))
    _tell_github(summary(done, path.name))
    _print(done, against is not None, console)
    console.say(f"written: {out}" + ("" if save_baseline is None else f", {save_baseline}"))
    return 0 if all(one.holds for one in done) else 1


def _chosen(claims: tuple[Claim, ...], only: list[str]) -> list[Claim]:
    names = [claim.name for claim in claims]
    for name in only:
        if name not in names:
            raise unknown("claim", name, names)
    return [claim for claim in claims if not only or claim.name in only]


def _print(done: list[Checked], compared: bool, console: Terminal) -> None:
    console.say(words.finding(done), "bold")
    order = {"fails": 0, "undecided": 1, "holds": 2}
    for d in sorted((d for one in done for d in one.decisions), key=lambda d: order[d.verdict or "undecided"]):
        verdict = d.verdict or "undecided"
        console.say(f"{verdict:<10}", COLOURS[verdict], f"{words.title(d)}: {words.sentence(d)}")
        for line in (words.measured(d), words.troubles(d), words.rates(d)):
            if line:
                console.say(" " * 10 + line)
    for one in done:
        if compared and one.baseline is None:
            console.say(f"{one.claim.name}: new, the baseline does not have it")
        if not one.same_recordings:
            console.say(
                f"{one.claim.name}: the baseline is of another version of the simulation: its runs are no pairs"
            )


def _tell_github(text: str) -> None:
    """Append the summary to the file that GitHub shows, where a workflow runs this."""
    path = os.environ.get(STEP_SUMMARY)
    if not path:
        return
    try:
        with Path(path).open("a", encoding="utf-8") as file:
            file.write(text)
    except OSError as error:
        raise InputError(f"{path}: expected a place that can be written, got: {error.strerror}") from None
