"""Whether what was found is in the simulator: 60 blind cases.  python -m benchmarks.blind_cases --help

The questions are those of `imubench prove` that have effects and a motion to show them: two thirds one effect, one
third two or three, on every rig, with every nuisance. Each recording is made by the independent generator (`proof`) and
diagnosed in a process that has the recording and nothing else (`trials.blind`); then MuJoCo's replay, `model/` and
`where` are scored as `prove` does (docs/proof-scoring.md). Short recordings come first. What is there is not done
again: the same command goes on, and `--spend` ends it after so many seconds of processor time.
"""

import argparse
import os
import platform
import resource
import shutil
import sys
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, fields
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from benchmarks.__main__ import processor
from benchmarks.real.steps import ROOT, commit
from benchmarks.real.table import replaced
from imubench.answers import write_json
from imubench.atomic import atomic_file
from imubench.diagnosis.result_read import read_diagnosis
from imubench.errors import InputError
from imubench.inputs.json import load_table
from imubench.lock import locked
from imubench.proof.mixture import Question, make, mixture
from imubench.proof.rigs import SHAPES
from imubench.terminal import Terminal
from imubench.trials.blind import OURS, Children, diagnosed, finished
from imubench.trials.detection import wilson
from imubench.trials.judge import scored
from imubench.trials.make import answers, freedom, rebuilt, shortened
from imubench.trials.replayed import NEAR, Replayed, replayed

CASES, SEED, SECONDS = 60, 20261201, 20.0
ASKED = 3  # questions of the mixture for each case that is wanted: of 100 it has 40 with one effect, 20 with several
HUNG = 3600.0  # s by the clock for a diagnosis, which itself ends after 600 s of processor time
AIMS = {
    "first sensor of `where` right": 0.90,
    "and its first channel": 0.83,
    f"name right: replay within {NEAR:g} of the fit's held-out misfit": 0.95,
}
RESULTS, HEADING = ROOT / "benchmarks" / "RESULTS.md", "## Modelled and shown, blind cases"
CASE = "case.json"


@dataclass(frozen=True)
class Scored:
    """What the simulations of one case were worth."""

    name: str
    rig: str
    seconds: float  # of recording
    truth: tuple[str, ...]  # "effect at place"
    found: tuple[str, ...]  # the sure ones, "effect at place (confidence)"
    failed: str  # why there is no diagnosis
    spent: float  # s of processor time, diagnosis and score
    commit: str
    replayed: Replayed

    @property
    def right(self) -> bool:
        """Whether every effect has its name and place."""
        return self.replayed.modelled is not None

    @property
    def near(self) -> bool:
        """Whether the replay is as near to the held-out samples as the fit."""
        return self.replayed.replay is not None and self.replayed.replay <= NEAR


def questions(count: int, seed: int, seconds: float) -> dict[str, Question]:
    """Return questions with effects that their motion can show, by name, short recordings first."""
    some = [q for q in mixture(seed, ASKED * count) if q.kind in ("one", "several") and q.observable][:count]
    cut = {f"{i:03d}": shortened(q, seconds) for i, q in enumerate(some)}
    return dict(sorted(cut.items(), key=lambda item: samples(item[1])))


def samples(question: Question) -> float:
    """Return how many samples of an IMU a recording has, about."""
    options = question.options
    return float(options["seconds"] * (options["rate"] + (options["rate2"] if SHAPES[question.rig].imus > 1 else 0.0)))


def asked(name: str, question: Question, out: Path) -> Scored:
    """Return the score of a case, after making and diagnosing it."""
    folder, began, said = out / name, spent(), commit()
    if not (folder / "truth.json").is_file():  # written last
        shutil.rmtree(folder, ignore_errors=True)
        told = case(question, folder / "recording")
        with atomic_file(folder / "truth.json") as partial:
            write_json(partial, told)
    truth = load_table(folder / "truth.json")
    run = finished(folder / "answer") or diagnosed(folder / "recording", folder / "answer", OURS, HUNG, Children())
    one = scored(name, truth, folder / "answer", run)
    worth = Replayed()
    if not one.failed:
        worth = replayed(truth, read_diagnosis(folder / "answer"), folder / "answer", folder / "recording")
    score = Scored(
        name, question.rig, question.options["seconds"], tuple(one.truth), one.found, one.failed, spent() - began, said,
        worth,
    )  # fmt: skip
    with atomic_file(folder / CASE) as partial:
        write_json(partial, asdict(score))
    return score


def case(question: Question, folder: Path) -> dict[str, Any]:
    """Write the recording of a question into the new folder, and return its truth, without Cramer-Rao bounds."""
    truth = make(question, folder)
    built = rebuilt(truth)
    told = {"answers": [answers(e, built.options) for e in built.effects]}
    told |= {"freedom": [freedom(e) for e in built.effects], "bounds": [None] * len(built.effects)}
    return truth | told


def spent() -> float:
    """Return the processor time of this process and of those that it has waited for, s."""
    own, others = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return own.ru_utime + own.ru_stime + others.ru_utime + others.ru_stime


def kept(name: str, out: Path) -> Scored | None:
    """Return the score of a case that an earlier run has; None where none has."""
    file = out / name / CASE
    if not file.is_file():
        return None
    content = load_table(file)
    worth: dict[str, Any] = content.pop("replayed")
    known = {f.name for f in fields(Replayed)}
    told = {key: tuple(value) if isinstance(value, list) else value for key, value in content.items()}
    return Scored(**told, replayed=Replayed(**{key: value for key, value in worth.items() if key in known}))


def cases(asked_for: dict[str, Question], out: Path, seconds: float, say: Terminal) -> Iterator[Scored]:
    """Yield the score of every case, making those that are not there until `seconds` of processor time are spent."""
    for name, question in asked_for.items():
        score = kept(name, out)
        if score is None and spent() < seconds:
            score = asked(name, question, out)
            say.say(row(score))
        if score is not None:
            yield score


def row(score: Scored) -> str:
    """Return a case as a row of the table."""
    r = score.replayed

    def yes(answer: bool | None) -> str:
        return "-" if answer is None else "right" if answer else "**wrong**"

    replay = "-" if r.replay is None else f"{r.replay:.2f}" if score.near else f"**{r.replay:.2f}**"
    disk = "-" if r.disk is None else f"{r.disk:.2f}"
    found = score.failed or ", ".join(score.found) or "nothing"
    rig = f"{score.rig}{', rolled out' if r.rolled_out else ''}"
    return (
        f"| {score.name} | {rig} | {', '.join(score.truth)} | {found} | {yes(r.sensor)} | {yes(r.first_channel)} | "
        f"{replay} | {disk} | {score.spent:.0f} |"
    )


def asked_right(scores: Sequence[Scored]) -> dict[str, list[bool]]:
    """Return for each of `AIMS` whether every case that it is asked of is right; a diagnosis that failed is wrong."""
    wrong = [False] * sum(bool(s.failed) for s in scores)
    sensor = [s.replayed.sensor for s in scores if s.replayed.sensor is not None]
    channel = [s.replayed.first_channel for s in scores if s.replayed.first_channel is not None]
    near = [s.near for s in scores if s.right]
    return dict(zip(AIMS, (sensor + wrong, channel + wrong, near), strict=True))


def share(right: Sequence[bool], aim: float, whole: bool) -> str:
    """Return how many are right, the 95 % interval of the share, and whether the aim is met: open of a part."""
    if not right:
        return f"none | {aim:.0%} | - |"
    hits, n = sum(right), len(right)
    low, high = wilson(hits, n)
    met = "open" if not whole else "yes" if hits >= aim * n else "**no**"
    return f"{hits} of {n}, {hits / n:.0%} ({low:.0%} to {high:.0%}) | {aim:.0%} | {met} |"


def table(scores: Sequence[Scored], of: int, seconds: float) -> str:
    """Return what the cases add up to, and each of them, in Markdown."""
    silent = sum(not (s.found or s.failed) for s in scores)
    commits = ", ".join(sorted({s.commit for s in scores})) or "none"
    lines = [
        f"`python -m benchmarks.blind_cases`, {datetime.now(UTC):%Y-%m-%d}, commit {commits}; {os.cpu_count()} cores, "
        f"{processor()}, Python {platform.python_version()}, beside other programs. **{len(scores)} of {of} cases were "
        f"run**, the shortest first, recordings of at most {seconds:g} s; in {silent} of them "
        "nothing was found, which is no answer about `where` or a replay. Right and wrong as in "
        f"[proof-scoring.md](../docs/proof-scoring.md#modelled-and-shown).",
        "",
        "| what | cases | aim | met |",
        "|---|---:|---:|---|",
        *(f"| {what} | {share(right, AIMS[what], len(scores) == of)}" for what, right in asked_right(scores).items()),
        "",
        "| case | rig | concealed | said | first sensor | first channel | replay | disk | processor time, s |",
        "|---|---|---|---|---|---|---:|---:|---:|",
        *(row(s) for s in scores),
    ]
    return "\n".join(lines)


def main(words: Sequence[str]) -> int:
    """Run what is asked for; return 0, 1 where an aim is missed, 2 for bad input, 130 after Ctrl-C."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.blind_cases", description=__doc__)
    parser.add_argument("--cases", type=int, default=CASES)
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--seconds", type=float, default=SECONDS, help="of a recording, at most")
    parser.add_argument("--spend", type=float, default=float("inf"), metavar="S", help="of processor time, in this run")
    parser.add_argument("--out", type=Path, default=Path("runs/blind"), help="where cases are kept")
    parser.add_argument("--write", action="store_true", help="put the table into RESULTS.md")
    given = parser.parse_args(words)
    say, out = Terminal(stderr=True), given.out.resolve() / f"{given.seed}-{given.seconds:g}"
    out.mkdir(parents=True, exist_ok=True)
    try:
        with locked(out / ".lock", given.out):
            asked_for = questions(given.cases, given.seed, given.seconds)
            scores = list(cases(asked_for, out, given.spend, say))
    except InputError as error:
        say.say(str(error))
        return 2
    except KeyboardInterrupt:
        say.say("interrupted; the same command goes on where it was")
        return 130
    text = table(scores, len(asked_for), given.seconds)
    print(text)
    if given.write:
        with atomic_file(RESULTS) as partial:
            partial.write_text(replaced(RESULTS.read_text(encoding="utf-8"), HEADING, text), encoding="utf-8")
    return int(not all(sum(of) >= AIMS[what] * len(of) for what, of in asked_right(scores).items()))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
