"""Datasets at size: rate and bytes of 1,000 recordings, the same bytes after kills, time and memory up to 10,000.

Ten minutes and 8 GB of a temporary folder: run by name alone, `python -m benchmarks dataset_runs`.
"""

import hashlib
import os
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks.table import Row

HINGE = "[[rig]]\nfamily = 'hinge'\n"
SPECS = {
    "rigid mounts": HINGE,
    "both IMUs on rocking springs of 5 to 25 Hz": HINGE + "rocking_probability = 1\n",
    "10 s each": "seconds = 10\n" + HINGE,
}
COUNT, SECONDS, RATE = 1000, 60, 100


@dataclass(frozen=True)
class Ran:
    """One run of the command."""

    wall: float  # s
    cpu: float  # s, of all its processes
    memory: float  # MB, of its largest process
    size: int  # bytes
    sha256: str  # of all names and contents
    load: float  # of the machine at the start, a minute's mean


def start(folder: Path, name: str, count: int, workers: int) -> subprocess.Popen[bytes]:
    """Start `imubench generate` of a spec into `folder`."""
    spec = folder.parent / f"{folder.name}.toml"
    spec.write_text(SPECS[name], encoding="utf-8")
    command = [sys.executable, "-m", "imubench", "generate", str(spec), "--count", str(count)]
    command += ["--workers", str(workers), "--out", str(folder)]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def ran(folder: Path, name: str, count: int, workers: int, kill: str = "") -> Ran:
    """Run to the end; `kill` "worker" or "run" does so by SIGKILL after 15 s, and a killed run is begun again."""
    load, begun = os.getloadavg()[0], time.monotonic()
    process = start(folder, name, count, workers)
    if kill:
        time.sleep(15.0)
        os.kill(_workers(process.pid)[0] if kill == "worker" else process.pid, signal.SIGKILL)
        if kill == "run":
            process.wait()
            if (folder / "manifest.json").exists():
                raise RuntimeError("the run was finished before it was killed")
            process = start(folder, name, count, workers)
    _, status, used = os.wait4(process.pid, 0)
    wall = time.monotonic() - begun
    if status:
        raise RuntimeError(f"{name}: status {status}")
    files = sorted(p for p in folder.rglob("*") if p.is_file())
    found = hashlib.sha256()
    for file in files:
        found.update(str(file.relative_to(folder)).encode() + hashlib.sha256(file.read_bytes()).digest())
    size = sum(f.stat().st_size for f in files)
    return Ran(wall, used.ru_utime + used.ru_stime, used.ru_maxrss / 1e3, size, found.hexdigest(), load)


def _workers(parent: int) -> list[int]:
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit() and b"spawn_main" in (entry / "cmdline").read_bytes():
            fields = (entry / "stat").read_text().rpartition(")")[2].split()
            found += [int(entry.name)] if int(fields[1]) == parent else []
    return found


def run() -> list[Row]:
    """Return all rows."""
    rows = []
    with TemporaryDirectory() as scratch:
        root = Path(scratch)
        for name in list(SPECS)[:2]:
            two = ran(root / "two", name, COUNT, 2)
            rate = COUNT * SECONDS / two.wall
            what = (
                f"dataset, {COUNT:,} recordings of {SECONDS} s at {RATE} Hz, two workers, {name}, load {two.load:.1f}"
            )
            ours = f"{rate:,.0f} s/s, {rate * RATE:,.0f} samples/s, {two.size / 1e6 * 3600 / COUNT / SECONDS:.0f} MB/h"
            rows.append(Row(what, ours, "-", "-", "-", True))
            if name == "rigid mounts":
                rows += _same(root, name, two)
            _removed(root / "two")
        rows += _growth(root)
    return rows


def _same(root: Path, name: str, two: Ran) -> list[Row]:
    rows = []
    for what, workers, kill in (
        ("one process", 0, ""),
        ("four workers", 4, ""),
        ("two workers, one killed after 15 s", 2, "worker"),
        ("two workers, the run killed after 15 s and begun again", 2, "run"),
    ):
        again = ran(root / "again", name, COUNT, workers, kill)
        _removed(root / "again")
        same = again.sha256 == two.sha256
        what = f"dataset, {COUNT:,} recordings of {SECONDS} s, {name}, {what}: SHA-256 of all files beside two workers'"
        rows.append(Row(what, again.sha256[:12], two.sha256[:12], "-", "the same", same))
    return rows


def _growth(root: Path) -> list[Row]:
    runs = []
    for count in (100, 1000, 10_000):
        runs.append((count, ran(root / "grown", "10 s each", count, 0)))
        _removed(root / "grown")
    first, rows = runs[0][1], []
    for (count, one), (before, last) in zip(runs[1:], runs[:-1], strict=True):
        each, earlier = one.cpu / count, last.cpu / before
        what = f"dataset, {count:,} recordings of 10 s in one process beside {before:,}: CPU ms each, MB of memory"
        ours, peer = (f"{1e3 * t:.1f} ms, {r.memory:.0f} MB" for t, r in ((each, one), (earlier, last)))
        flat = each < 1.2 * earlier and one.memory < 1.05 * first.memory
        rows.append(Row(what, ours, peer, f"{each / earlier:.2f}", "flat", flat))
    return rows


def _removed(folder: Path) -> None:
    for path in sorted(folder.rglob("*"), reverse=True):
        path.rmdir() if path.is_dir() else path.unlink()
    folder.rmdir()
