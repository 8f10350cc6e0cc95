"""A dataset is made, or gone on with: shards first, in any order, each finished or not there; the manifest last."""

import json
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

from imubench.dataset.card import CARD, card
from imubench.dataset.engines import ENGINES
from imubench.dataset.lock import locked
from imubench.dataset.manifest import MANIFEST, encoded, identity, manifest, spec_names
from imubench.dataset.shard import RECEIPTS, Job, Receipt, finished, names
from imubench.dataset.storage import Folder, cannot_write
from imubench.errors import InputError, unknown

LOCK, JOB = f"{RECEIPTS}/lock", f"{RECEIPTS}/job.json"
SAME = {"spec": "another spec", "seed": "another seed", "count": "another count"}

Report = Callable[[str, int, int], None]
"""Called with what is counted, how many are done, and how many there are."""


def generate(job: Job, workers: int, engine: str = "local", report: Report = lambda *_: None) -> dict[str, Any]:
    """Make the dataset of a job and return its manifest; one that is finished already is left as it is.

    A run that was stopped, however, goes on where it was, to the same bytes. Raises `InputError` for a folder of
    anything else, of another job, one that another run is writing to, or that cannot be written.
    """
    if engine not in ENGINES:
        raise unknown("engine", engine, ENGINES)
    if job.count < 1:
        raise InputError(f"count: expected 1 or more, got {job.count}")
    folder = Folder(job.out)
    _check_ours(folder)
    done = _complete(folder, job)
    if done is not None:
        return done
    with locked(Path(job.out) / LOCK, job.out):
        _remove_partials(folder)
        done = _complete(folder, job)  # another run may have finished it meanwhile
        if done is None:
            try:
                done = _made(folder, job, workers, engine, report)
            finally:
                _remove_partials(folder)
        _remove_receipts(folder)
    return done


def _made(folder: Folder, job: Job, workers: int, engine: str, report: Report) -> dict[str, Any]:
    _begin(folder, job)
    receipts: list[Receipt] = []
    left = []
    for number in range(job.shards):
        receipt = finished(job, number)
        if receipt is None:
            left.append(number)
        else:
            receipts.append(receipt)

    def tell() -> None:
        report("recordings", sum(r.recordings for r in receipts), job.count)

    tell()
    with closing(ENGINES[engine](job, left, workers)) as made:
        for receipt in made:
            receipts.append(receipt)
            tell()
    table = manifest(job, receipts)
    text = card(job.spec, table, (folder.root / names(number)[1] for number in range(job.shards)))
    folder.write(CARD, text.encode())
    table["files"][CARD] = {"sha256": folder.sha256(CARD), "bytes": folder.size(CARD)}
    folder.write(MANIFEST, encoded(table))
    return table


def _check_ours(folder: Folder) -> None:
    """Raise `InputError` unless nothing is there, or what a run of ours left."""
    root = folder.root
    try:
        if not root.exists():
            return
        if not root.is_dir():
            raise InputError(f"{folder.path}: expected a folder to write, got a file of that name")
        there = {path.name for path in root.iterdir()}
    except OSError as error:
        raise cannot_write(root, error) from None
    if there and not there & {MANIFEST, RECEIPTS}:
        raise InputError(f"{folder.path}: expected a new or empty folder, or a dataset, got one with '{min(there)}'")


def _complete(folder: Folder, job: Job) -> dict[str, Any] | None:
    """Return the manifest where the dataset is finished; `InputError` where it is that of another job."""
    found = folder.read_json(MANIFEST)
    if found is None:
        if folder.size(MANIFEST) is not None:
            raise InputError(f"{folder.path}/{MANIFEST}: expected the manifest of a dataset, got something else")
        return None
    _check_same(folder, job, found)
    return found


def _begin(folder: Folder, job: Job) -> None:
    """Note what is being made, once, and keep a copy of the spec."""
    begun = folder.read_json(JOB)
    if begun is None:
        folder.write(JOB, json.dumps(identity(job)).encode())
    else:
        _check_same(folder, job, begun)
    for name, content in spec_names(job).items():
        folder.write(name, content)


def _check_same(folder: Folder, job: Job, found: dict[str, Any]) -> None:
    for key, wanted in identity(job).items():
        if found.get(key) != wanted:
            what = SAME.get(key, "another version of the software or another kind of machine")
            got = f"{what} ({key} {found.get(key)!r}, now {wanted!r})" if key in ("seed", "count") else what
            raise InputError(f"{folder.path}: expected a folder of this dataset or a new one, got one of {got}")


def _remove_partials(folder: Folder) -> None:
    """Remove what workers were writing when they died; none of it has a name that counts."""
    for name in folder.names():
        if Path(name).name.startswith(".") and ".partial." in name:
            folder.remove(name)


def _remove_receipts(folder: Folder) -> None:
    for name in folder.names():
        if name.startswith(f"{RECEIPTS}/"):
            folder.remove(name)
