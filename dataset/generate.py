"""A dataset is made, or gone on with: shards first, in any order, each finished or not there; the manifest last."""

import json
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from typing import IO, Any

from imubench.atomic import cannot_write
from imubench.dataset.card import CARD, card
from imubench.dataset.engines import ENGINES
from imubench.dataset.identity import identity
from imubench.dataset.manifest import MANIFEST, checked, encoded, manifest, spec_names
from imubench.dataset.published.croissant import CROISSANT, croissant
from imubench.dataset.published.readme import README, readme
from imubench.dataset.remote import place
from imubench.dataset.shard import RECEIPTS, Job, Receipt, finished, is_there, receipt_name
from imubench.dataset.storage import Folder, Place
from imubench.errors import InputError, unknown
from imubench.lock import locked
from imubench.progress import Report

LOCK, JOB = f"{RECEIPTS}/lock", f"{RECEIPTS}/job.json"
SAME = {"spec": "another spec", "seed": "another seed", "count": "another count"}


def generate(
    job: Job,
    workers: int | None,
    engine: str = "local",
    report: Report = lambda *_: None,
    address: str | None = None,
) -> dict[str, Any]:
    """Make the dataset of a job and return its manifest; one that is finished already is left as it is.

    `workers` None: as many as the engine has cores. `address`: of the engine's cluster. A run that was stopped goes on
    where it was, to the same bytes. Raises `InputError` for a folder of anything else, of another job, one that another
    run is writing to (of a URL this is not known), or that cannot be written.
    """
    if engine not in ENGINES:
        raise unknown("engine", engine, ENGINES)
    if job.count < 1:
        raise InputError(f"count: expected 1 or more, got {job.count}")
    ENGINES[engine].check(workers, address)
    folder = place(job.out)
    _check_ours(folder)
    done = _complete(folder, job)
    if done is not None and RECEIPTS not in folder.entries():
        return done
    with _alone(folder):
        _remove_partials(folder)
        done = _complete(folder, job)  # another run may have finished it meanwhile
        if done is None:
            try:
                done = _made(folder, job, workers, engine, report, address)
            finally:
                _remove_partials(folder)
        _remove_receipts(folder)
    return done


@contextmanager
def _alone(folder: Place) -> Iterator[None]:
    """Keep other runs away from a folder on a disk; of a storage by URL nothing is known."""
    if not isinstance(folder, Folder):
        yield
        return
    lock = folder.root / LOCK
    try:
        lock.parent.mkdir(parents=True, exist_ok=True)
        with locked(lock, folder.path):
            yield
    except OSError as error:
        raise cannot_write(folder.path, error) from None
    finally:
        with suppress(OSError):  # something is left to go on with
            lock.parent.rmdir()


def _made(
    folder: Place, job: Job, workers: int | None, engine: str, report: Report, address: str | None
) -> dict[str, Any]:
    _begin(folder, job)
    receipts: list[Receipt] = []
    left = []
    listed = set(folder.names())
    for number in range(job.shards):
        receipt = finished(job, number) if receipt_name(number) in listed else None
        if receipt is None:
            left.append(number)
        else:
            receipts.append(receipt)

    def tell() -> None:
        report("recordings", sum(r.recordings for r in receipts), job.count)

    tell()
    with closing(ENGINES[engine].run(job, left, workers, address)) as made:
        for receipt in made:
            if not is_there(job, receipt):
                raise InputError(
                    f"{folder.path}: expected a place that all workers and this process see, got one where "
                    f"{min(receipt.files)} is not, which a worker wrote"
                )
            receipts.append(receipt)
            tell()
    table = manifest(job, receipts)
    written = {
        CARD: card(job.spec, table, _tables(folder, list(table["files"]))),
        README: readme(job.spec, table),
        CROISSANT: croissant(job.spec, table),
    }
    for name, text in written.items():
        folder.write(name, text.encode())
        table["files"][name] = {"sha256": folder.sha256(name), "bytes": folder.size(name)}
    folder.write(MANIFEST, encoded(table))
    return table


def _tables(folder: Place, files: Sequence[str]) -> Iterator[Path | IO[bytes]]:
    for name in files:
        if name.startswith("recordings/"):
            with folder.reading(name) as file:
                yield file


def _check_ours(folder: Place) -> None:
    """Raise `InputError` unless nothing is there, or what a run of ours left."""
    there = folder.entries()
    if there and not there & {MANIFEST, RECEIPTS}:
        raise InputError(f"{folder.path}: expected a new or empty folder, or a dataset, got one with '{min(there)}'")


def _complete(folder: Place, job: Job) -> dict[str, Any] | None:
    """Return the manifest where the dataset is finished; `InputError` where it is that of another job."""
    found = folder.read_json(MANIFEST)
    if found is None:
        if folder.size(MANIFEST) is not None:
            raise InputError(f"{folder.path}/{MANIFEST}: expected the manifest of a dataset, got something else")
        return None
    _check_same(folder, job, found)
    return checked(found, f"{folder.path}/{MANIFEST}")


def _begin(folder: Place, job: Job) -> None:
    """Note what is being made, once, and keep a copy of the spec."""
    begun = folder.read_json(JOB)
    if begun is None:
        folder.write(JOB, json.dumps(identity(job)).encode())
    else:
        _check_same(folder, job, begun)
    for name, content in spec_names(job).items():
        folder.write(name, content)


def _check_same(folder: Place, job: Job, found: dict[str, Any]) -> None:
    for key, wanted in identity(job).items():
        if found.get(key) != wanted:
            what = SAME.get(key, "another version of the software or another kind of machine")
            got = f"{what} ({key} {found.get(key)!r}, now {wanted!r})" if key in ("seed", "count") else what
            raise InputError(f"{folder.path}: expected a folder of this dataset or a new one, got one of {got}")


def _remove_partials(folder: Place) -> None:
    """Remove what workers were writing when they died; none of it has a name that counts."""
    folder.remove([name for name in folder.names() if Path(name).name.startswith(".") and ".partial." in name])


def _remove_receipts(folder: Place) -> None:
    folder.remove([name for name in folder.names() if name.startswith(f"{RECEIPTS}/")])
