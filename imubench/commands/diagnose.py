"""`imubench diagnose`: where a recording differs from its model, and because of what."""

from pathlib import Path
from typing import Annotated

import typer

from imubench.commands.command import RECORDING, Command, Out, console, errors


def diagnose_command(
    recording: Annotated[str, typer.Argument(help=RECORDING)],
    out: Out = None,
    time_limit: Annotated[
        float, typer.Option("--time-limit", help="Seconds of processor time; then what is known is said.", min=1)
    ] = 600.0,
    tolerance: Annotated[
        str, typer.Option("--tolerance", metavar="DEG,MM", help="What moves less is immaterial and raises no alarm.")
    ] = "0.5,5",
    baseline: Annotated[
        str | None,
        typer.Option("--baseline", help="An undisturbed recording of the same sensors, or its diagnosis."),
    ] = None,
) -> None:
    """Say where a recording differs from its model, and what physics the model leaves out.

    The motion that explains all sensors best is found from the recording
    alone, played through the declared model, and compared with the samples.
    A reference in the recording never enters that; it only judges.

    Written are diagnosis.json with every number, report.html for people,
    diagnosis.rrd for Rerun, and model/, a simulation with what was found in
    it, which `imubench run DIR/model` replays. Without --out: runs/diagnosis-NAME.

    First the sensors are held against each other: two recordings in one, a
    mirrored or a stuck sensor, swapped files and too few samples are said in
    words, and nothing is fitted. At the time limit the search stops, and the
    verdict is no surer than what was tried.

    Each finding says by how much it moves joint axis, joint centre, hinge
    angle and orientation. What moves none of them by --tolerance is listed
    as immaterial: every sensor has a bias, and a clock that is late by a bit.

    With --baseline the sensors' own errors (bias, scale, misalignment,
    g-sensitivity, noise, rounding, filter) are those of an earlier recording,
    as well as that shows them, and only what is new is found. A recording is
    diagnosed first, into DIR/baseline, in at most half of the time limit.

    Exit code 2 for bad input, with one line about it.
    """
    from imubench.commands.work.diagnose import run as run_diagnosis
    from imubench.sources import label

    out = out or Path("runs") / f"diagnosis-{label(recording)}"
    run_diagnosis(recording, out, time_limit, tolerance, baseline, console, errors)


COMMAND = Command(
    "diagnose",
    diagnose_command,
    (
        "imubench diagnose my-recording --out diagnosis",
        "imubench diagnose my-recording --time-limit 120 --tolerance 1,10",
        "imubench diagnose my-recording --baseline undisturbed",
    ),
)
