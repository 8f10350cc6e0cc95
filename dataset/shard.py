"""A shard: so many recordings in a row, as one file of samples and one of recordings for each split among them.

What is in a shard follows from the job and its number alone, to the bit, so it does not matter who makes it, when, or
how often. Its receipt is written last and says that it is finished.
"""

import json
import math
import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq
from threadpoolctl import threadpool_limits

from imubench.dataset import columns, rows
from imubench.dataset.checks import are_counts, are_files, is_whole, lasts
from imubench.dataset.drawing import split_of
from imubench.dataset.identity import identity
from imubench.dataset.playing import make
from imubench.dataset.published.columns import with_units
from imubench.dataset.remote import place
from imubench.dataset.spec import Spec, parse_spec
from imubench.dataset.storage import described

PARQUET = {
    "compression": "zstd",
    "compression_level": 3,
    "use_dictionary": ["split"],
    "write_statistics": ["recording", "split", "time"],
}
RECEIPTS = ".generate"  # a hidden folder, gone when the manifest is there


@dataclass(frozen=True)
class Job:
    """What a dataset is, small enough to be sent to every worker."""

    content: Mapping[str, bytes] = field(repr=False)  # the spec's file and those it names
    seed: int
    count: int  # recordings
    out: str  # the folder, or its URL

    @property
    def spec(self) -> Spec:
        """The spec, checked; read once a process."""
        return _spec(tuple(sorted(self.content.items())))

    @property
    def shards(self) -> int:
        """How many shards the recordings fill."""
        return -(-self.count // self.spec.recordings_per_file)

    def indices(self, number: int) -> range:
        """Return the recordings of a shard."""
        size = self.spec.recordings_per_file
        return range(number * size, min((number + 1) * size, self.count))

    def make(self, number: int) -> "Receipt":
        """Make and write a shard; `InputError` where it cannot be written."""
        return make_shard(self, number)

    def finished(self, number: int) -> "Receipt | None":
        """Return the receipt of a shard whose files are there in full."""
        return finished(self, number)

    def identity(self) -> dict[str, Any]:
        """Return what decides about the bytes."""
        return identity(self)

    def by_split(self, number: int) -> dict[str, list[int]]:
        """Return the recordings of a shard by split, splits in the order of the spec and none of them empty."""
        spec, indices = self.spec, self.indices(number)
        rigs = {index // spec.recordings_per_rig for index in indices}
        splits = {rig: split_of(spec, self.seed, rig) for rig in rigs}
        found: dict[str, list[int]] = {name: [] for name in spec.splits}
        for index in indices:
            found[splits[index // spec.recordings_per_rig]].append(index)
        return {name: own for name, own in found.items() if own}


@dataclass(frozen=True)
class Receipt:
    """A finished shard."""

    number: int
    recordings: int
    samples: int  # rows
    seconds: float  # recorded
    splits: Mapping[str, int]  # recordings by split
    files: Mapping[str, Mapping[str, Any]]  # name -> sha256, bytes, rows

    @property
    def size(self) -> int:
        """Bytes of its files."""
        return sum(int(file["bytes"]) for file in self.files.values())


@lru_cache(maxsize=2)
def _spec(content: tuple[tuple[str, bytes], ...]) -> Spec:
    return parse_spec(dict(content))


def names(number: int, split: str) -> tuple[str, str]:
    """Return the names of a shard's files of samples and of recordings of a split."""
    return f"samples/{split}-{number:05d}.parquet", f"recordings/{split}-{number:05d}.parquet"


def receipt_name(number: int) -> str:
    """Return the name of a shard's receipt."""
    return f"{RECEIPTS}/{number:05d}.json"


def make_shard(job: Job, number: int) -> Receipt:
    """Make and write a shard, one recording after the other in memory; `InputError` where it cannot be written."""
    folder = place(job.out)
    said: list[dict[str, Any]] = []
    files: dict[str, Mapping[str, Any]] = {}
    for split, indices in job.by_split(number).items():
        samples, recordings = names(number, split)
        with folder.writing(samples) as path:
            own = _write_samples(job, indices, path)
            files[samples] = described(path) | {"rows": sum(r["samples"] for r in own)}
        with folder.writing(recordings) as path:
            with path.open("wb") as file:
                pq.write_table(pa.Table.from_pylist(own, with_units(rows.schema(job.spec))), file, compression="zstd")
            files[recordings] = described(path) | {"rows": len(own)}
        said += own
    receipt = Receipt(
        number,
        len(said),
        sum(r["samples"] for r in said),
        math.fsum(r["seconds"] for r in said),
        dict(Counter(r["split"] for r in said)),
        files,
    )
    folder.write(receipt_name(number), json.dumps(receipt.__dict__).encode())
    return receipt


def _write_samples(job: Job, indices: Sequence[int], path: Path) -> list[dict[str, Any]]:
    """Make recordings and write their samples, a row group each; return their rows of the table of recordings."""
    spec, said = job.spec, []
    form = with_units(columns.schema(spec))
    floats = [f.name for f in form if pa.types.is_floating(f.type)]
    # A file of Python's, which goes on where a write is interrupted or cut short; Arrow's own does not.
    with (
        threadpool_limits(1),
        path.open("wb") as file,
        pq.ParquetWriter(file, form, use_byte_stream_split=floats, **PARQUET) as writer,
    ):
        for index in indices:
            made = make(spec, job.seed, index)
            writer.write_table(columns.samples_table(spec, made), row_group_size=sys.maxsize)
            said.append(rows.row(made, job.seed))
    return said


def finished(job: Job, number: int) -> Receipt | None:
    """Return the receipt of a shard whose files are there in full; None for one that is to be made (again)."""
    found = place(job.out).read_json(receipt_name(number))
    if found is None or set(found) != {f.name for f in Receipt.__dataclass_fields__.values()}:
        return None
    receipt = Receipt(**found)
    whole = all(map(is_whole, (receipt.number, receipt.recordings, receipt.samples))) and lasts(receipt.seconds)
    whole = whole and receipt.number == number and are_counts(receipt.splits) and are_files(receipt.files)
    if not whole:
        return None
    wanted = job.by_split(number)
    if receipt.splits != {split: len(own) for split, own in wanted.items()}:  # not what we write
        return None
    if set(receipt.files) != {name for split in wanted for name in names(number, split)}:
        return None
    counted = all(is_whole(file.get("rows")) for file in receipt.files.values())
    if not counted or receipt.recordings != len(job.indices(number)):
        return None
    return receipt if is_there(job, receipt) else None


def is_there(job: Job, receipt: Receipt) -> bool:
    """Return whether the files of a receipt are where this process looks for them, in full."""
    folder = place(job.out)
    return all(folder.size(name) == file["bytes"] for name, file in receipt.files.items())
