"""What a finished dataset says about itself: manifest.json, written last, with the hash of every other file."""

import hashlib
import json
import math
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from imubench.dataset.checks import are_counts, are_files, is_count, is_whole, lasts
from imubench.dataset.identity import identity
from imubench.dataset.remote import place
from imubench.dataset.shard import RECEIPTS, Job, Receipt
from imubench.dataset.spec import SPEC_FILE
from imubench.dataset.storage import Place
from imubench.errors import InputError, shown
from imubench.inputs.files import below

MANIFEST = "manifest.json"
FORMAT = 2  # 1: shards in one file for all splits
READABLE = (1, FORMAT)


def spec_names(job: Job) -> dict[str, bytes]:
    """Return the copies of the spec's files that are kept with the data, by name."""
    return {f"spec/{name}": content for name, content in sorted(job.content.items())}


def manifest(job: Job, receipts: Sequence[Receipt]) -> dict[str, Any]:
    """Return the content of manifest.json; the same shards give the same, in whatever order they were finished."""
    spec = job.spec
    receipts = sorted(receipts, key=lambda r: r.number)
    splits: Counter[str] = Counter()
    listed = {
        name: {"sha256": hashlib.sha256(content).hexdigest(), "bytes": len(content)}
        for name, content in spec_names(job).items()
    }
    for receipt in receipts:
        splits.update(receipt.splits)
        listed |= {name: dict(entry) for name, entry in receipt.files.items()}
    return {
        "format": FORMAT,
        "kind": "imubench dataset",
        "name": spec.name,
        "summary": spec.summary,
        "licence": spec.terms.licence,
        "version": spec.terms.version,
        **identity(job),
        "spec_text": job.content[SPEC_FILE].decode(),
        "recordings_per_file": spec.recordings_per_file,
        "rigs": -(-job.count // spec.recordings_per_rig),
        "recordings": {name: splits[name] for name in spec.splits},
        "seconds": math.fsum(r.seconds for r in receipts),  # rounded once, so the order of the shards is no matter
        "samples": sum(r.samples for r in receipts),
        "rate": spec.rate,
        "files": listed,
    }


def encoded(table: dict[str, Any]) -> bytes:
    """Return a table as the bytes of a JSON file."""
    return (json.dumps(table, indent=1) + "\n").encode()


def read_manifest(folder: Place) -> dict[str, Any]:
    """Return the manifest of a finished dataset; `InputError` where there is none."""
    found = folder.read_json(MANIFEST)
    if found is None:
        begun = any(name.startswith(RECEIPTS) for name in folder.names())
        why = "one that is not finished: the same command goes on" if begun else f"no {MANIFEST} that can be read"
        raise InputError(f"{folder.path}: expected a finished dataset, got {why}")
    return checked(found, f"{folder.path}/{MANIFEST}")


def checked(found: dict[str, Any], where: str) -> dict[str, Any]:
    """Return a manifest; `InputError` where it is of another format or lacks what readers need of it."""
    if found.get("format") not in READABLE or isinstance(found.get("format"), bool):
        raise InputError(f"{where}: expected a dataset of format 1 or {FORMAT}, got {shown(found.get('format'))}")
    for key, (fits, wanted) in KINDS.items():
        if not fits(found.get(key)):
            raise InputError(f"{where}, key '{key}': expected {wanted}, got {shown(found.get(key))}")
    return found


KINDS: dict[str, tuple[Callable[[object], bool], str]] = {
    "count": (is_count, "a number of recordings"),
    "recordings_per_file": (is_count, "a number of recordings"),
    "rigs": (is_whole, "a number of rigs"),
    "recordings": (are_counts, "recordings by split"),
    "seconds": (lasts, "1 s or more"),
    "samples": (is_whole, "a number of samples"),
    "files": (are_files, "the hash and size of each file"),
}


def verify(path: str) -> dict[str, Any]:
    """Return the manifest of a dataset whose files are all there and as they were written.

    Raises `InputError` naming each file that is missing, changed, or not of this dataset.
    """
    folder = place(path)
    found = read_manifest(folder)
    wrong = [f"{name} ({why})" for name, why in _wrong(folder, found["files"])]
    if wrong:
        shown = ", ".join(wrong[:5]) + (f" and {len(wrong) - 5} more" if len(wrong) > 5 else "")
        raise InputError(f"{path}: expected the files of {MANIFEST}, got {shown}")
    return found


def _wrong(folder: Place, listed: dict[str, dict[str, Any]]) -> Iterable[tuple[str, str]]:
    for name, entry in listed.items():
        below(Path(folder.path), name, f"{folder.path}/{MANIFEST}, key 'files'")
        size = folder.size(name)
        if size is None:
            yield name, "missing"
        elif size != entry["bytes"]:
            yield name, f"{size} bytes, not {entry['bytes']}"
        elif folder.sha256(name) != entry["sha256"]:
            yield name, "changed"
    for name in folder.names():
        if name.startswith(("samples/", "recordings/")) and name not in listed:
            yield name, "not of this dataset"
