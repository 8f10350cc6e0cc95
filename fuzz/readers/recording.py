"""Recordings in format 1, and the mark of an output folder that the next run may replace."""

from pathlib import Path

from fuzz.mutate import csv, json, mjcf, parquet, toml
from fuzz.reader import Reader
from fuzz.seeds import recordings
from imubench import format1
from imubench.atomic import atomic_directory
from imubench.models import RigFile
from imubench.models.outside import plain_of


def read(f: Path, o: Path) -> object:
    """Read a recording and its reference."""
    return format1.read(f)


def estimate(f: Path, o: Path) -> list[str]:
    """Return the words of an estimate on it."""
    return ["estimate", "seel2012", str(f), "--out", str(o)]


def offered(f: Path, o: Path) -> object:
    """Read the rig of a package."""
    return plain_of("theirs", RigFile("theirs", (f / "theirs.xml").read_text(encoding="utf-8", errors="replace")))


def replace(f: Path, o: Path) -> object:
    """Write an output folder in the place of one that an earlier run left."""
    with atomic_directory(f / "out") as folder:
        (folder / "new").write_text("new")
    return True


READERS = (
    Reader("recording-toml", "recording.toml", recordings.as_csv, toml.mutate, read, estimate),
    *(
        Reader(f"{name}-csv", f"{name}.csv", recordings.as_csv, csv.mutate, read, estimate)
        for name in ("imu2", "encoder", "pose1", "reference")
    ),
    *(
        Reader(f"{name}-parquet", f"{name}.parquet", recordings.as_parquet, parquet.mutate, read, estimate)
        for name in ("imu2", "pose1", "reference")
    ),
    Reader("rig-mjcf", "my.xml", recordings.with_rig, mjcf.mutate, read, estimate),
    Reader("package-mjcf", "theirs.xml", recordings.of_a_package, mjcf.mutate, offered, as_text=True),
    Reader("out-marker", "out/.imubench.json", recordings.marked, json.mutate, replace, writes="when accepted"),
)
