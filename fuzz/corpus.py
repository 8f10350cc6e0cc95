"""Failures that were found, one file each: tests/corpus/READER/KIND-HASH.bin is the content of the reader's target."""

import hashlib
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
CORPUS = ROOT / "tests" / "corpus"
LARGEST = 20_000  # bytes of an entry; what needs more is made by code, in `bombs.py`


def entries(corpus: Path = CORPUS) -> Iterator[tuple[str, Path]]:
    """Yield the reader's name and the file of every entry."""
    for file in sorted(corpus.glob("*/*.bin")):
        yield file.parent.name, file


def keep(corpus: Path, reader: str, what: str, content: bytes) -> Path:
    """Write a failing content, the same one once."""
    kind = what.removeprefix("command: ").partition(":")[0].replace(" ", "-")
    file = corpus / reader / f"{kind}-{hashlib.sha256(content).hexdigest()[:8]}.bin"
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_bytes(content)
    return file
