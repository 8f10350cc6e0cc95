"""A shard: so many recordings in a row, as one file of samples and one of recordings.

What is in a shard follows from the job and its number alone, to the bit, so it does not matter who makes it, when, or
how often. Its receipt is written last and says that it is finished.
"""

import json
import math
import sys
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq
from threadpoolctl import threadpool_limits

from imubench.dataset import columns, rows
from imubench.dataset.checks import are_counts, are_files, is_whole, lasts
from imubench.dataset.identity import identity
from imubench.dataset.playing import make
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


@dataclass(frozen=True)
class Receipt:
    """A finished shard."""

    number: int
    recordings: int
    samples: int  # rows
    seconds: float  # recorded
    splits: Mapping[str, int]  # recordings by split
    files: Mapping[str, Mapping[str, Any]]  # name -> sha256, bytes

    @property
    def size(self) -> int:
        """Bytes of its files."""
        return sum(int(file["bytes"]) for file in self.files.values())


@lru_cache(maxsize=2)
def _spec(content: tuple[tuple[str, bytes], ...]) -> Spec:
    return parse_spec(dict(content))


def names(number: int) -> tuple[str, str]:
    """Return the names of a shard's files of samples and of recordings."""
    return f"samples/part-{number:05d}.parquet", f"recordings/part-{number:05d}.parquet"


def receipt_name(number: int) -> str:
    """Return the name of a shard's receipt."""
    return f"{RECEIPTS}/{number:05d}.json"


def make_shard(job: Job, number: int) -> Receipt:
    """Make and write a shard, one recording after the other in memory; `InputError` where it cannot be written."""
    spec, folder = job.spec, place(job.out)
    samples, recordings = names(number)
    form = columns.schema(spec)
    floats = [f.name for f in form if pa.types.is_floating(f.type)]
    said, files = [], {}
    with threadpool_limits(1), folder.writing(samples) as path:
        # A file of Python's, which goes on where a write is interrupted or cut short; Arrow's own does not.
        with path.open("wb") as file, pq.ParquetWriter(file, form, use_byte_stream_split=floats, **PARQUET) as writer:
            for index in job.indices(number):
                made = make(spec, job.seed, index)
                writer.write_table(columns.samples_table(spec, made), row_group_size=sys.maxsize)  # a group a recording
                said.append(rows.row(made, job.seed))
        files[samples] = described(path)
    with folder.writing(recordings) as path:
        with path.open("wb") as file:
            pq.write_table(pa.Table.from_pylist(said, rows.schema(spec)), file, compression="zstd")
        files[recordings] = described(path)
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


def finished(job: Job, number: int) -> Receipt | None:
    """Return the receipt of a shard whose files are there in full; None for one that is to be made (again)."""
    found = place(job.out).read_json(receipt_name(number))
    if found is None or set(found) != {f.name for f in Receipt.__dataclass_fields__.values()}:
        return None
    receipt = Receipt(**found)
    whole = all(map(is_whole, (receipt.number, receipt.recordings, receipt.samples))) and lasts(receipt.seconds)
    whole = whole and receipt.number == number and are_counts(receipt.splits) and are_files(receipt.files)
    if not whole or set(receipt.files) != set(names(number)):  # not what we write
        return None
    counts = receipt.splits
    if not receipt.recordings == len(job.indices(number)) == sum(counts.values()) or set(counts) - set(job.spec.splits):
        return None
    return receipt if is_there(job, receipt) else None


def is_there(job: Job, receipt: Receipt) -> bool:
    """Return whether the files of a receipt are where this process looks for them, in full."""
    folder = place(job.out)
    return all(folder.size(name) == file["bytes"] for name, file in receipt.files.items())
