"""How many files and rows the tables of a dataset have in each split, from its manifest."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

TABLES = ("samples", "recordings")


@dataclass(frozen=True)
class Part:
    """A table's part in one split."""

    files: int
    rows: int

    def __add__(self, other: "Part") -> "Part":
        return Part(self.files + other.files, self.rows + other.rows)


def parts(manifest: Mapping[str, Any], table: str) -> dict[str, Part]:
    """Return a table's parts by split; splits without a recording have none."""
    found = dict.fromkeys(manifest["recordings"], Part(0, 0))
    for name, entry in manifest["files"].items():
        folder, _, file = name.partition("/")
        if folder == table:
            found[file.rpartition("-")[0]] += Part(1, entry["rows"])
    return {split: part for split, part in found.items() if part.files}
