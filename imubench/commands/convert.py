"""`imubench convert`: a known dataset or file into format 1."""

from pathlib import Path
from typing import Annotated

import typer

from imubench.commands.command import Command, check_order, console, errors, say_written
from imubench.errors import InputError
from imubench.progress import on_console


def convert(
    format: Annotated[str, typer.Argument(help="A format of `imubench list`.")],
    source: Annotated[Path, typer.Argument(help="A file or folder in that format.")],
    out: Annotated[Path, typer.Option("--out", help="Folder for the recording, or for one folder each.")],
    option: Annotated[list[str] | None, typer.Option(help="key=value; an unknown key names the known ones.")] = None,
    table: Annotated[str, typer.Option(help="csv or parquet.")] = "csv",
) -> None:
    """Convert a known dataset or file into format 1."""
    from imubench.atomic import atomic_directory
    from imubench.convert import CONVERTERS
    from imubench.errors import unknown
    from imubench.format1 import write_recording
    from imubench.inputs.files import plain_name

    check_order(format, str(source), CONVERTERS, "imubench convert")
    if format not in CONVERTERS:
        raise unknown("format", format, CONVERTERS)
    if table not in ("csv", "parquet"):
        raise unknown("table", table, ("csv", "parquet"))
    converter, options = CONVERTERS[format], options_of(option or [])
    inputs = [source, *converter.files(source, options)]
    with on_console(errors)(f"convert {source}"), atomic_directory(out, inputs) as folder:
        converted = converter(source, **options)
        for one in converted:
            name = plain_name(one.recording.name, f"{source}: name of a recording")
            target = folder if len(converted) == 1 else folder / name
            write_recording(one.recording, target, one.reference, table)  # type: ignore[arg-type]
    for one in converted:
        console.say(f"{one.recording.name}: {one.note}")
    say_written(out)


def options_of(pairs: list[str]) -> dict[str, str]:
    """Return key=value pairs as a dictionary; `InputError` for one that is none."""
    options = {}
    for pair in pairs:
        key, equals, value = pair.partition("=")
        if not equals or not key:
            raise InputError(f"--option: expected key=value, got '{pair}'")
        options[key.replace("-", "_")] = value
    return options


COMMAND = Command(
    "convert",
    convert,
    (
        "imubench convert csv samples.csv --option gyro_unit=deg/s --out my-recording",
        "imubench convert diodem trial1 --option segments=3-4 --option imu=rigid --out knee",
    ),
)
