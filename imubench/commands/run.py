"""`imubench run`: simulate a scenario or replay a diagnosis' model, estimate, score and log."""

from pathlib import Path
from typing import Annotated

import typer

from imubench.commands.command import (
    Band,
    Command,
    Out,
    TimeLimit,
    console,
    errors,
    folder_name,
    say_written,
)
from imubench.errors import InputError
from imubench.progress import on_console


def run(
    scenario: Annotated[str, typer.Argument(help="A scenario of `imubench list`, or model/ of a diagnosis.")],
    estimator: Annotated[
        str | None,
        typer.Option(
            help="An estimator of `imubench list`, FILE.py:FUNCTION or PACKAGE.MODULE:FUNCTION.", show_default=False
        ),
    ] = None,
    seed: Annotated[int, typer.Option(help="The same seed gives the same numbers.", min=0)] = 0,
    imu: Annotated[
        str | None, typer.Option("--profile", help="Another IMU, of `imubench list profiles`.", show_default=False)
    ] = None,
    duration: Annotated[
        float | None, typer.Option("--duration", help="Seconds, instead of the scenario's own.", show_default=False)
    ] = None,
    effect: Annotated[
        list[str] | None,
        typer.Option(
            "--effect",
            help="Left-out physics NAME@PLACE:KEY=VALUE,...; a value may be LOW..HIGH. May be given again.",
            show_default=False,
        ),
    ] = None,
    band: Band = None,
    time_limit: TimeLimit = None,
    on: Annotated[
        str | None,
        typer.Option(help="A recording: roll a diagnosis' model/ out through its free swings.", show_default=False),
    ] = None,
    out: Out = None,
) -> None:
    """Simulate a scenario, estimate, score, and log it: score.json, recording/, run.rrd.

    Exit code 1 where an estimator from outside fails; score.json says how.

    The model/ of a diagnosis is played again: rolled out by forces alone inside
    its free swings, elsewhere with the motion that was recovered. With --on it is
    rolled out through the free swings of another recording of the same rig, from
    the state at their starts, beside the model that this recording declares:
    simulation.json says how far each is off, by channel.
    """
    from imubench.answers import pairing_note
    from imubench.commands.shown import say_band, say_failed, say_figures, say_note
    from imubench.dataset.effect_text import effect_from_text
    from imubench.run import Changes, run_scenario
    from imubench.scenarios import known_scenarios

    if on is not None:
        from imubench.commands.work.run_on import run as run_on
        from imubench.sources import label

        given = {"--estimator": estimator, "--band": band, "--profile": imu, "--duration": duration, "--effect": effect}
        more = [option for option, value in given.items() if value is not None]
        if more:
            raise InputError(f"--on: expected it without {', '.join(more)}")
        run_on(Path(scenario), on, out or Path("runs") / f"{Path(scenario).name}-on-{label(on)}", console, errors)
        return
    out = out or Path("runs") / (folder_name(scenario) if scenario in known_scenarios() else Path(scenario).name)
    changes = Changes(imu, duration, tuple(effect_from_text(text) for text in effect or ()))
    done = run_scenario(scenario, out, estimator, seed, on_console(errors), band, time_limit, changes)
    if done.failed is not None:
        say_failed(done.failed, out)
    elif done.estimate is None or done.score is None:
        console.say(f"{scenario}: simulated; name an --estimator to estimate and score")
    else:
        title = f"{scenario}, seed {seed}: {done.estimate.estimator} ({done.estimate.status})"
        say_figures(title, done.score.figures, done.score.units)
        say_note(pairing_note(done.estimate, done.recording))
        say_band(done.estimate)
    say_written(out, "run.rrd")
    if done.failed is not None:
        raise typer.Exit(1)


COMMAND = Command(
    "run",
    run,
    (
        "imubench run hinge-hand --estimator seel2012",
        "imubench run hinge-hand --estimator mine.py:estimate --time-limit 60",
        "imubench run olsson2020/motion-11 --profile mpu9250 --duration 30",
        "imubench run hinge-hand --effect soft_mount@imu2:frequency=9,damping_ratio=0.1 --effect gyro_bias:bias=0.01",
        "imubench run diagnosis/model --on another-recording",
    ),
)
