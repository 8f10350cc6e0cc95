"""`imubench generate` and `imubench verify`: a bar of what is done, the figures, one line for what is wrong."""

import time
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

from imubench.atomic import atomic_directory, check_apart
from imubench.dataset.exports import EXPORTS
from imubench.dataset.generate import generate
from imubench.dataset.manifest import verify
from imubench.dataset.published.notes import before_publishing, empty_splits
from imubench.dataset.reading import Stored, indices, read
from imubench.dataset.shard import Job
from imubench.dataset.spec import SPEC_FILE, load_spec
from imubench.errors import InputError, unknown
from imubench.progress import bars, on_console
from imubench.signals import promising
from imubench.sources import in_dataset
from imubench.terminal import Terminal


def run(
    spec: Path,
    count: int,
    seed: int,
    out: str | None,
    workers: int | None,
    engine: str,
    address: str | None,
    console: Terminal,
    errors: Terminal,
) -> None:
    """Make a dataset into `out` and print what there is."""
    found = load_spec(spec)
    target = out or str(Path("runs") / found.name)
    if "://" not in target:
        check_apart(Path(target), [spec, *(spec.parent / name for name in found.content if name != SPEC_FILE)])
    job = Job(found.content, seed, count, target)
    for line in empty_splits(job):
        console.say("warning: ", "yellow", line)
    start = time.perf_counter()
    with promising("finished files are kept: the same command goes on from there"), bars(errors) as report:
        made = generate(job, workers, engine, report, address)
    hours, size = made["seconds"] / 3600, sum(file["bytes"] for file in made["files"].values())
    splits = ", ".join(f"{name} {n}" for name, n in made["recordings"].items())
    console.print(
        f"{count} recordings of {made['rigs']} rigs ({splits}): {hours:.2f} h, {made['samples']:,} samples",
        soft_wrap=True,
    )
    console.print(
        f"{size / 1e6:,.1f} MB, {size / 1e6 / hours:,.1f} MB per recorded hour; {time.perf_counter() - start:.1f} s"
    )
    console.say(f"written: {target}")
    if line := before_publishing(job):
        console.say(line)


def export(
    form: str, folder: str, out: Path, split: str | None, count: int | None, console: Terminal, errors: Terminal
) -> None:
    """Write recordings of a dataset, or the one that DIR#17 names, in another form and print how many."""
    if form not in EXPORTS:
        raise unknown("form", form, EXPORTS)
    folder, one = in_dataset(folder) or (folder, None)
    if one is not None and (split is not None or count is not None):
        raise InputError(f"{folder}#{one}: expected one recording without --split and --count, got one of them")
    inputs = [] if "://" in folder else [Path(folder)]
    with bars(errors) as report, atomic_directory(out, inputs) as target:
        chosen = list(islice(indices(folder, split), count)) if one is None else [one]

        def one_by_one() -> Iterator[Stored]:
            for done, index in enumerate(chosen):
                report("recordings", done, len(chosen))
                yield read(folder, index)

        EXPORTS[form](one_by_one(), target)
    console.say(f"{len(chosen)} recordings written: {out}")


def check(folder: str, console: Terminal, errors: Terminal) -> None:
    """Check every file of a dataset against its manifest and print what there is."""
    with on_console(errors)(f"verify {folder}"):
        found = verify(folder)
    total = sum(found["recordings"].values())
    console.say(f"{folder}: {total} recordings, {len(found['files'])} files as in manifest.json")
