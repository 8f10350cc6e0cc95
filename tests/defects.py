"""Readers with one defect each, for the fuzzer's own tests: it must see every one of them."""

import os
import signal
import time
from pathlib import Path
from random import Random

import pyarrow as pa

from fuzz.reader import Reader

STRAY = Path("/tmp/imubench-fuzz/stray")


def files() -> dict[str, bytes]:
    return {"a.txt": b"a valid input\n"}


def mutate(content: bytes, rng: Random) -> bytes:
    return content[: rng.randint(0, len(content))] + b"\xff"


def good(f: Path, o: Path) -> None:
    o.mkdir()
    (o / "result").write_bytes((f / "a.txt").read_bytes())


def raising(f: Path, o: Path) -> None:
    raise KeyError("segment2")


def growing(f: Path, o: Path) -> None:
    blocks = []
    while True:
        blocks.append(b"x" * 100_000_000)


def peaking(f: Path, o: Path) -> None:
    len(b"x" * 700_000_000)  # gone again before anybody looks


def computing(f: Path, o: Path) -> None:
    while True:
        pass


def waiting(f: Path, o: Path) -> None:
    time.sleep(1_000)


def crashing(f: Path, o: Path) -> None:
    os.kill(os.getpid(), signal.SIGSEGV)


def reading(f: Path, o: Path) -> None:
    (f.parent / "outside" / "kept.csv").read_bytes()


def reading_past_python(f: Path, o: Path) -> None:
    with pa.OSFile(str(f.parent / "outside" / "kept.csv")) as file:
        file.read()


def writing(f: Path, o: Path) -> None:
    with (f.parent / "outside" / "kept.csv").open("a") as file:
        file.write("x")


def straying(f: Path, o: Path) -> None:
    STRAY.write_text("x")
    STRAY.unlink()


def removing(f: Path, o: Path) -> None:
    (f.parent / "outside" / "kept.toml").unlink()


def changing(f: Path, o: Path) -> None:
    (f / "a.txt").write_bytes(b"another one\n")


def leaving(f: Path, o: Path) -> None:
    Path("MUJOCO_LOG.TXT").write_text("x")


def picky(f: Path, o: Path) -> None:
    """Fails where one line has a comma and another, later, two bytes in a row."""
    lines = (f / "a.txt").read_bytes().splitlines()
    if any(b"," in a and b"zz" in b for i, a in enumerate(lines) for b in lines[i + 1 :]):
        raise ValueError("found")


DEFECTS = (
    good, raising, growing, peaking, computing, waiting, crashing, reading, reading_past_python, writing, straying,
    removing, changing, leaving, picky,
)  # fmt: skip
READERS = {read.__name__: Reader(read.__name__, "a.txt", files, mutate, read) for read in DEFECTS}


def outside() -> dict[str, bytes]:
    return {"kept.csv": b"time\n0\n", "kept.toml": b""}
