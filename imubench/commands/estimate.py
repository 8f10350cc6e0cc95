"""`imubench estimate`: an estimator on a recording from disk."""

from pathlib import Path
from typing import Annotated

import typer

from imubench.commands.command import (
    RECORDING,
    Band,
    Command,
    Out,
    TimeLimit,
    check_order,
    console,
    errors,
    folder_name,
    say_written,
)
from imubench.inputs.files import NOTHING, what_is
from imubench.progress import on_console


def estimate(
    name: Annotated[
        str, typer.Argument(help="An estimator of `imubench list`, FILE.py:FUNCTION or PACKAGE.MODULE:FUNCTION.")
    ],
    recording: Annotated[str, typer.Argument(help=RECORDING)],
    diagnosis: Annotated[
        Path | None, typer.Option("--with", help="Take out first what `imubench diagnose` found, from its folder.")
    ] = None,
    band: Band = None,
    time_limit: TimeLimit = None,
    out: Out = None,
) -> None:
    """Estimate on a recording from disk, real or not: estimate.json, run.rrd, corrected/ where asked --with.

    Exit code 1 where an estimator from outside fails; estimate.json says how.
    """
    import numpy as np

    from imubench.answers import pairing_note
    from imubench.commands.shown import say_band, say_failed, say_figures, say_moved, say_note
    from imubench.plugins import known_estimators
    from imubench.run import NoEstimateError, estimate_on_disk
    from imubench.sources import in_dataset, label

    swapped = what_is(Path(name)) == "a folder" or in_dataset(name) is not None
    if what_is(Path(recording)) == NOTHING and swapped:
        known = [*known_estimators(), *([recording] if ":" in recording else [])]
        check_order(name, recording, known, "imubench estimate")
    out = out or Path("runs") / f"{folder_name(Path(name).name)}-{label(recording)}"
    try:
        done = estimate_on_disk(name, recording, out, on_console(errors), diagnosis, band, time_limit)
    except NoEstimateError as error:
        say_failed(error.failed, out)
        say_written(out)
        raise typer.Exit(1) from None
    for finding in done.done:
        console.say(f"{finding.effect} at {finding.at}: {finding.what}")
    if done.diagnosis is not None and not done.done:
        console.say(f"{done.diagnosis.verdict}: the diagnosis has no findings, nothing is corrected")
    answer = done.estimate
    console.say(f"{done.recording.name}: {name} ({answer.status})", "bold")
    for i, value in enumerate(np.atleast_2d(answer.value if answer.time is None else answer.value[-1])):
        console.say(f"  {done.recording.imus[i].name}: {np.array2string(value, precision=4, floatmode='fixed')}")
    say_note(pairing_note(answer, done.recording))
    say_band(answer)
    if done.uncorrected is not None and done.done:
        say_moved(done.uncorrected, answer, [imu.name for imu in done.recording.imus])
    for beside, what in ((done.beside_reference, "the reference"), (done.beside_declared, "the declared mounts")):
        if beside is not None:
            say_figures(f"beside {what}", beside.figures, beside.units)
    say_written(out, "run.rrd")


COMMAND = Command(
    "estimate",
    estimate,
    (
        "imubench estimate seel2012 runs/hinge-hand/recording",
        "imubench estimate mine.py:estimate my-recording --out mine",
        "imubench estimate olsson2020 my-recording --with diagnosis",
    ),
)
