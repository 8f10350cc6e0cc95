"""`imubench run MODEL_DIR --on RECORDING`: a diagnosis' model rolled out through another recording's free swings."""

from pathlib import Path

from rich.table import Table

from imubench.answers import write_json
from imubench.atomic import atomic_directory
from imubench.diagnosis.report.numbers import shown
from imubench.diagnosis.result_file import simulation_as_dict
from imubench.diagnosis.simulation.model_folder import is_model
from imubench.diagnosis.simulation.on_recording import OnRecording, judged_on
from imubench.errors import InputError
from imubench.progress import on_console
from imubench.sources import Source, read
from imubench.terminal import Terminal

FILE_NAME = "simulation.json"


def run(model: Path, recording: Source, out: Path, console: Terminal, errors: Terminal) -> None:
    """Roll a model out through a recording's free swings, write simulation.json into `out` and print the table.

    Raises:
        InputError: for a folder that is no model, and as `judged_on` does.
    """
    if not is_model(model):
        raise InputError(f"{model}: expected the model/ folder of a diagnosis with --on, got something else")
    step = on_console(errors)
    with atomic_directory(out, [model, Path(recording)]) as folder:
        with step(f"read {recording}"):
            judged = read(recording)[0]
        done = judged_on(model, judged, step)
        content = {"format": 1, "model_of": done.model_of, "recording": done.recording}
        write_json(folder / FILE_NAME, content | {"simulation": simulation_as_dict(done.simulation)})
    print_table(done, console)
    console.say(f"written: {out / FILE_NAME}")


def print_table(done: OnRecording, console: Terminal) -> None:
    """Print how far both models are from every channel."""
    s = done.simulation
    seconds = sum(end - start for start, end in s.windows_s)
    whose = "another recording" if s.heldout else "the same recording"
    console.say(
        f"{done.recording}: {seconds:.1f} s of free swing rolled out, RMS of simulated minus measured; "
        f"the model is of {whose}, {done.model_of}"
    )
    table = Table(box=None, header_style="bold", padding=(0, 2, 0, 0))
    for column in ("channel", "as declared", "with the model", "noise", "unit"):
        table.add_column(column, justify="left" if column in ("channel", "unit") else "right")
    for name, c in s.channels.items():
        factor, unit = shown(1.0, c.unit)
        table.add_row(name, *(f"{factor * x:.3g}" for x in (c.before, c.after, c.noise)), unit)
    console.print(table)
