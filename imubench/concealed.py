"""The main promise in one go: what is concealed in a recording is found, modelled, played, drawn, and corrected for.

The recording and the truth about it lie in two places (scripts/concealed_recording.py makes both). The recording alone
is copied out and diagnosed; the truth is read when the answer is on the disk.
"""

import shlex
import shutil
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import as_file, files
from pathlib import Path
from typing import Any

import numpy as np
from rich.box import SIMPLE
from rich.table import Table

from imubench.answers import beside_axes
from imubench.arrays import Array, frozen
from imubench.atomic import atomic_directory
from imubench.diagnosis.on_disk import LOG, MODEL, REPORT, STEP_BEGINNINGS, diagnose_on_disk
from imubench.diagnosis.on_disk import Done as Diagnosed
from imubench.diagnosis.report import headline, words
from imubench.diagnosis.report.picture import draw_diagnosis
from imubench.inputs.toml import load_toml
from imubench.progress import Step, in_stages
from imubench.run import OnDisk, estimate_on_disk, run_scenario
from imubench.terminal import Terminal

SHIPPED = "concealed_recording"  # beside the scenarios
ESTIMATOR = "olsson2020"
PICTURE = "concealed.png"
CHANNELS = 4  # that differ most, of twelve


@dataclass(frozen=True)
class Answer:
    """What came out of a recording without its truth."""

    diagnosed: Diagnosed
    before: OnDisk  # estimated from the recording as it is
    after: OnDisk  # and with what was found taken out of it


@dataclass(frozen=True)
class Truth:
    """What is true of a recording: what was concealed in it, and where the hinge axis is."""

    effects: list[dict[str, Any]]  # effect, at, parameters
    joint_axes: Array  # (2, 3), unit, in the axes of imu1 and imu2

    def __post_init__(self) -> None:
        object.__setattr__(self, "joint_axes", frozen(self.joint_axes, (2, 3), "joint_axes"))


def answered(recording: Path, out: Path, step: Step, stages: Step) -> Answer:
    """Diagnose a recording, estimate the hinge axis without and with that, and play what was found; all below `out`.

    Args:
        recording: a folder in format 1; nothing else is read.
        out: holds diagnosis/, before/, after/ and replayed/ then.
        step: told what is being done.
        stages: told the stages of the diagnosis.
    """
    diagnosis = out / "diagnosis"
    before = estimate_on_disk(ESTIMATOR, recording, out / "before", step)
    diagnosed = diagnose_on_disk(recording, diagnosis, stages)
    after = estimate_on_disk(ESTIMATOR, recording, out / "after", step, diagnosis)
    run_scenario(str(diagnosis / MODEL), out / "replayed", step=step)
    return Answer(diagnosed, before, after)


def opened(path: Path) -> Truth:
    """Return the truth about a recording; `InputError` for a damaged file."""
    told = load_toml(path)
    return Truth(told["effects"], np.array(told["joint_axes"]))


def off(answer: Answer, truth: Truth) -> tuple[Array, Array]:
    """Return by how many deg the estimated hinge axis is off at each IMU, (2,) without and (2,) with the diagnosis."""
    found = []
    for one in (answer.before, answer.after):
        judged = beside_axes(one.estimate, one.recording, truth.joint_axes)
        assert judged is not None  # a hinge's axis, and its truth
        found.append(np.rad2deg([judged.deviation(imu.name) or 0.0 for imu in one.recording.imus]))
    return found[0], found[1]


def show(out: Path, console: Terminal, errors: Terminal, step: Step) -> None:
    """Diagnose the shipped recording into the folder `out`, print the answer, then the truth, and draw both."""
    with as_file(files("imubench.scenarios") / SHIPPED) as shipped:
        recording = out / "recording"
        with atomic_directory(recording) as target:
            shutil.copytree(shipped / "recording", target, dirs_exist_ok=True)
        answer = answered(recording, out, step, in_stages(errors, STEP_BEGINNINGS))
        say_answer(answer, console)
        truth = opened(shipped / "concealed.toml")
    errors_deg = off(answer, truth)
    say_truth(answer, truth, errors_deg, console)
    with step("draw"):
        diagnosed = answer.diagnosed
        draw_diagnosis(out / PICTURE, diagnosed.diagnosis, diagnosed.evidence, errors_deg, "the true one")
    say_more(out, console)


def say_answer(answer: Answer, console: Terminal) -> None:
    """Print what the diagnosis says, and by how much the simulations are off."""
    d = answer.diagnosed.diagnosis
    imus = answer.before.recording.imus
    seconds = max(imu.time[-1] for imu in imus) - min(imu.time[0] for imu in imus)
    console.say(f"\n{seconds:.0f} s of two IMUs on a hinge; what differs from its simulation is concealed.", "bold")
    console.say(
        d.verdict, "bold green" if words.VERDICT_LOOKS[d.verdict] == "good" else "bold", f": {headline.headline(d)}"
    )
    if d.simulation is None:
        return
    console.say("MuJoCo's simulation is off by (RMS):")
    table = table_of(("channel", "unit"), ("as declared", "with what was found", "sensor noise"))
    for one in headline.deviations(d.simulation)[:CHANNELS]:
        table.add_row(words.spelled(one.channel), one.unit, one.before, one.after, one.noise)
    console.print(table)
    for done in answer.after.done:
        console.say(f"{words.sentence(words.called(done.effect, done.at))}: {done.what}")


def say_truth(answer: Answer, truth: Truth, errors_deg: tuple[Array, Array], console: Terminal) -> None:
    """Print how far the hinge axis is off without and with the diagnosis, and what was concealed."""
    names = [imu.name for imu in answer.before.recording.imus]
    console.say(f"The truth is opened. Angle in deg between the hinge axis of {ESTIMATOR} and the true one:")
    table = table_of(("estimated", "status"), names)
    rows = (("from the recording as it is", answer.before), ("with what was found taken out", answer.after))
    for (text, one), angles in zip(rows, errors_deg, strict=True):
        table.add_row(text, one.estimate.status, *(f"{angle:.2f}" for angle in angles))
    console.print(table)
    for effect in truth.effects:
        console.say(f"Concealed was {words.called(effect['effect'], effect['at'])}:")
        found = [f for f in answer.diagnosed.diagnosis.findings if (f.effect, f.at) == (effect["effect"], effect["at"])]
        table = table_of(("", "concealed", "found", "unit"), ())
        for name, value in effect["parameters"].items():
            told = [f.parameters[name] for f in found if name in f.parameters]
            said = (numbers(told[0].value), told[0].unit.removesuffix("1")) if told else ("assumed as that", "")
            table.add_row(name.replace("_", " "), numbers(value), *said)
        console.print(table)


def table_of(texts: Sequence[str], figures: Sequence[str]) -> Table:
    """Return an empty table with columns of text, and of numbers."""
    table = Table(box=SIMPLE, padding=(0, 1, 0, 0))
    for column in texts:
        table.add_column(column, no_wrap=True)
    for column in figures:
        table.add_column(column, justify="right", no_wrap=True)
    return table


def numbers(value: Any) -> str:
    """Return a number or some, short."""
    return ", ".join(f"{x + 0.0:.3g}" for x in np.round(np.atleast_1d(value), 4).ravel())


def say_more(out: Path, console: Terminal) -> None:
    """Print where everything lies, and what to type to look further."""
    recording, diagnosis = (shlex.quote(str(out / name)) for name in ("recording", "diagnosis"))
    for what, line in (
        ("the picture", out / PICTURE),
        ("the report", out / "diagnosis" / REPORT),
        ("in 3D", f"rerun {shlex.quote(str(out / 'diagnosis' / LOG))}"),
        ("the axis", f"imubench estimate {ESTIMATOR} {recording} --with {diagnosis}"),
        ("the model", f"imubench run {shlex.quote(str(out / 'diagnosis' / MODEL))}"),
        ("all of it", f"imubench diagnose {recording}"),
    ):
        console.say(f"{what + ':':<12} {line}")
    console.say(f"imubench and rerun are in {Path(sys.executable).parent}")


__all__ = ["Answer", "Truth", "answered", "off", "opened", "show"]
