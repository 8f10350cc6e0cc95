"""`imubench generate` and `imubench verify`: a bar of what is done, the figures, one line for what is wrong."""

import time
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

from rich.console import Console
from rich.markup import escape

from imubench.atomic import atomic_directory
from imubench.cli_prove import bars
from imubench.dataset.exports import EXPORTS
from imubench.dataset.generate import generate
from imubench.dataset.manifest import verify
from imubench.dataset.reading import Stored, indices, read
from imubench.dataset.shard import Job
from imubench.dataset.spec import load_spec
from imubench.errors import unknown


def run(
    spec: Path,
    count: int,
    seed: int,
    out: str | None,
    workers: int | None,
    engine: str,
    address: str | None,
    console: Console,
    errors: Console,
) -> None:
    """Make a dataset into `out` and print what there is."""
    found = load_spec(spec)
    target = out or str(Path("runs") / found.name)
    job = Job(found.content, seed, count, target)
    start = time.perf_counter()
    try:
        with bars(errors) as report:
            made = generate(job, workers, engine, report, address)
    except KeyboardInterrupt:
        errors.print("finished files are kept: the same command goes on from there")
        raise
    hours, size = made["seconds"] / 3600, sum(file["bytes"] for file in made["files"].values())
    splits = ", ".join(f"{escape(name)} {n}" for name, n in made["recordings"].items())
    console.print(
        f"{count} recordings of {made['rigs']} rigs ({splits}): {hours:.2f} h, {made['samples']:,} samples",
        soft_wrap=True,
    )
    console.print(
        f"{size / 1e6:,.1f} MB, {size / 1e6 / hours:,.1f} MB per recorded hour; {time.perf_counter() - start:.1f} s"
    )
    console.print(f"written: {target}", soft_wrap=True)


def export(
    form: str, folder: str, out: Path, split: str | None, count: int | None, console: Console, errors: Console
) -> None:
    """Write recordings of a dataset in another form and print how many."""
    if form not in EXPORTS:
        raise unknown("form", form, EXPORTS)
    chosen = list(islice(indices(folder, split), count))
    with bars(errors) as report, atomic_directory(out) as target:

        def one_by_one() -> Iterator[Stored]:
            for done, index in enumerate(chosen):
                report("recordings", done, len(chosen))
                yield read(folder, index)

        EXPORTS[form](one_by_one(), target)
    console.print(f"{len(chosen)} recordings written: {out}", soft_wrap=True)


def check(folder: str, console: Console, errors: Console) -> None:
    """Check every file of a dataset against its manifest and print what there is."""
    with errors.status(f"verify {folder} ..."):
        found = verify(folder)
    total = sum(found["recordings"].values())
    console.print(f"{folder}: {total} recordings, {len(found['files'])} files as in manifest.json", soft_wrap=True)
