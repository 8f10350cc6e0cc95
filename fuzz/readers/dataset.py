"""Specs with the files they name, and datasets: finished, half done, in use by another run."""

import fcntl
import os
from pathlib import Path
from typing import Any

from fuzz.mutate import bytes as plain
from fuzz.mutate import csv, json, parquet, toml
from fuzz.reader import Reader
from fuzz.seeds import datasets
from imubench.dataset.exports import EXPORTS
from imubench.dataset.generate import generate
from imubench.dataset.manifest import verify
from imubench.dataset.playing import make
from imubench.dataset.reading import indices, read
from imubench.dataset.spec import load_spec
from imubench.lock import locked
from imubench.sim.profiles import load_profiles

PLAYED = 3_000  # samples of a recording that a fuzzer waits for


def long(f: Path) -> bool:
    """Return whether a spec asks for recordings that are long to make."""
    spec = load_spec(f / "spec.toml")
    return spec.seconds.high * spec.rate > PLAYED


def drawn(f: Path, o: Path) -> object:
    """Read a spec and make its first recording, where that is short."""
    return None if long(f) else make(load_spec(f / "spec.toml"), 0, 0)


def generated(f: Path, o: Path) -> list[str]:
    """Return the words that make a dataset of one recording."""
    return ["generate", str(f / "spec.toml"), "--count", "1", "--workers", "0", "--out", str(o)]


def profiled(f: Path, o: Path) -> object:
    """Read IMU profiles alone, as from Python."""
    return load_profiles(f / "profiles.toml")


def verified(f: Path, o: Path) -> object:
    """Check a dataset against its manifest."""
    return verify(str(f / "data"))


def verified_by_url(f: Path, o: Path) -> object:
    """The same at a URL, and read every recording from there."""
    url = f"file://{f}/data"
    for index in list(indices(url))[: datasets.COUNT]:
        read(url, index)
    return verify(url)


def exported(f: Path, o: Path) -> object:
    """Read every recording of a dataset and export it in every form."""
    chosen = list(indices(f / "data"))[: datasets.COUNT]
    for form, export in EXPORTS.items():
        (o / form).mkdir(parents=True)
        export((read(f / "data", index) for index in chosen), o / form)
    return chosen


def resumed(f: Path, o: Path) -> object:
    """Go on with a dataset where an earlier run ended."""
    return generate(datasets.job(f), workers=0)


def refused_by_lock(f: Path, o: Path) -> object:
    """Begin a run in a folder whose lock another one holds."""
    handle = os.open(f / "lock", os.O_RDWR)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX)  # as another run would
        with locked(f / "lock", "data"):
            return True
    finally:
        os.close(handle)


def verify_words(f: Path, o: Path) -> list[str]:
    """Return the words that verify a dataset."""
    return ["verify", str(f / "data")]


def verify_url_words(f: Path, o: Path) -> list[str]:
    """Return the words that verify a dataset at a URL."""
    return ["verify", f"file://{f}/data"]


def export_words(f: Path, o: Path) -> list[str]:
    """Return the words that export a dataset."""
    return ["export", "qmt", str(f / "data"), "--out", str(o)]


def resume_words(f: Path, o: Path) -> list[str]:
    """Return the words that go on with a dataset."""
    words = ["generate", str(f / "spec.toml"), "--count", str(datasets.COUNT), "--workers", "0"]
    return [*words, "--out", str(f / "data")]


def _resumed(name: str, target: str, files: Any, mutate: Any) -> Reader:
    return Reader(name, f"data/{target}", files, mutate, resumed, resume_words, writes="always")


MANIFEST, ROWS, SAMPLES = "data/manifest.json", "recordings/train-00000.parquet", "samples/train-00000.parquet"
READERS = (
    Reader("spec-toml", "spec.toml", datasets.spec, toml.mutate, drawn, generated, long),
    Reader("spec-profiles-toml", "profiles.toml", datasets.spec, toml.mutate, drawn, generated, long),
    Reader("profiles-toml", "profiles.toml", datasets.spec, toml.mutate, profiled),
    Reader("spec-motion-csv", "moves.csv", datasets.spec, csv.mutate, drawn, generated, long),
    Reader("spec-motion-parquet", "moves.parquet", datasets.spec_parquet, parquet.mutate, drawn, generated, long),
    Reader("manifest-verify", MANIFEST, datasets.finished, json.mutate, verified, verify_words),
    Reader("manifest-export", MANIFEST, datasets.finished, json.mutate, exported, export_words),
    _resumed("manifest-resume", "manifest.json", datasets.finished, json.mutate),
    Reader("recordings-parquet", f"data/{ROWS}", datasets.finished, parquet.mutate, exported, export_words),
    Reader("samples-parquet", f"data/{SAMPLES}", datasets.finished, parquet.mutate, exported, export_words),
    _resumed("job-json", ".generate/job.json", datasets.half_done, json.mutate),
    _resumed("receipt-json", ".generate/00000.json", datasets.half_done, json.mutate),
    _resumed("recordings-resume", ROWS, datasets.half_done, plain.flip),
    Reader("remote-manifest", MANIFEST, datasets.finished, json.mutate, verified_by_url, verify_url_words),
    Reader("remote-samples", f"data/{SAMPLES}", datasets.finished, parquet.mutate, verified_by_url, verify_url_words),
    Reader("lock", "lock", datasets.in_use, plain.mutate, refused_by_lock, refuses="another run holds it"),
)
