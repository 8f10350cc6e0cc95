"""`imubench generate`, `verify` and `export`: labelled recordings in bulk."""

from pathlib import Path
from typing import Annotated

import typer

from imubench.commands.command import Command, check_order, console, errors
from imubench.errors import InputError


def generate_command(
    spec: Annotated[Path, typer.Argument(help="A spec: what rigs, motions, IMUs and effects are drawn from.")],
    count: Annotated[int, typer.Option(help="How many recordings.", min=1, max=2**31 - 1)],
    seed: Annotated[int, typer.Option(help="The same seed gives the same bytes.", min=0, max=2**63 - 1)] = 0,
    workers: Annotated[int | None, typer.Option(help="Processes; none: one a core, 0: only this one.", min=0)] = None,
    engine: Annotated[str, typer.Option(help="Who makes the recordings: local or ray.")] = "local",
    address: Annotated[str | None, typer.Option(help="Of the Ray cluster.", show_default=False)] = None,
    out: Annotated[str | None, typer.Option("--out", help="Folder, or URL, to write.", show_default=False)] = None,
) -> None:
    """Generate a dataset of labelled recordings: Parquet files, manifest.json.

    Any recording follows from the spec, the seed and its number alone. After
    Ctrl-C, a kill or a full disk the same command goes on where it was, to the
    same bytes. Without --out: runs/NAME, by the name in the spec.
    """
    from imubench.commands.work.generate import run as run_generation

    run_generation(spec, count, seed, out, workers, engine, address, console, errors)


def verify_command(folder: Annotated[str, typer.Argument(help="A dataset of `imubench generate`.")]) -> None:
    """Check every file of a dataset against the hashes in its manifest.json."""
    from imubench.commands.work.generate import check

    check(folder, console, errors)


def export_command(
    words: Annotated[list[str], typer.Argument(metavar="FORM DATASET", help="The form, and a dataset or DIR#17.")],
    out: Annotated[Path, typer.Option("--out", help="Folder for the files.")],
    form: Annotated[str | None, typer.Option(help="The form, instead of the first word.", show_default=False)] = None,
    split: Annotated[str | None, typer.Option(help="Only the recordings of a split.", show_default=False)] = None,
    count: Annotated[int | None, typer.Option(help="At most so many.", min=1, show_default=False)] = None,
) -> None:
    """Export recordings of a dataset: folders in format1, .mat for qmt, .sto for opensim, .npz for imt-ring (ring).

    DIR#17 exports that recording alone. `imubench export qmt DIR --out mats` and
    `imubench export --form qmt DIR --out mats` are the same.
    """
    from imubench.commands.work.generate import export
    from imubench.dataset.exports import EXPORTS

    given = words if form is None else [form, *words]
    if len(given) != 2:
        raise InputError(f"export: expected a form and one dataset, got {' '.join(given)}")
    check_order(given[0], given[1], EXPORTS, "imubench export")
    export(given[0], given[1], out, split, count, console, errors)


GENERATE = Command(
    "generate",
    generate_command,
    (
        "imubench generate spec.toml --count 1000 --seed 1 --out data",
        "imubench generate spec.toml --count 100000 --engine ray --out s3://bucket/data",
    ),
)
VERIFY = Command("verify", verify_command, ("imubench verify data", "imubench verify s3://bucket/data"))
EXPORT = Command(
    "export",
    export_command,
    (
        "imubench export qmt data --out mats",
        "imubench export ring data --split train --out npz",
        "imubench export format1 data#17 --out one",
    ),
)
