"""What a run came to: a row a reader, and every kind of failure once."""

from collections import defaultdict
from dataclasses import dataclass, field

from fuzz.verdict import Outcome
from fuzz.worker import Task


@dataclass
class Row:
    """Counts of one reader."""

    inputs: int = 0
    commands: int = 0  # of them through the whole command
    accepted: int = 0
    refused: int = 0
    failed: int = 0
    longest: float = 0.0  # s of processor time
    largest: float = 0.0  # MB


@dataclass
class Failure:
    """A kind of failure: the first input that failed so, and how many did."""

    task: Task
    outcome: Outcome
    count: int = 1


@dataclass
class Table:
    """Everything that was counted."""

    rows: dict[str, Row] = field(default_factory=lambda: defaultdict(Row))
    failures: dict[tuple[str, str], Failure] = field(default_factory=dict)

    def add(self, task: Task, outcome: Outcome) -> bool:
        """Count an outcome; return whether it is a failure of a kind not seen before."""
        row = self.rows[task.reader]
        row.inputs += 1
        row.commands += task.command
        setattr(row, outcome.verdict, getattr(row, outcome.verdict) + 1)
        row.longest, row.largest = max(row.longest, outcome.seconds), max(row.largest, outcome.megabytes)
        if outcome.verdict != "failed":
            return False
        key = (task.reader, outcome.what)
        if key in self.failures:
            self.failures[key].count += 1
            return False
        self.failures[key] = Failure(task, outcome)
        return True

    @property
    def inputs(self) -> int:
        """How many were counted."""
        return sum(row.inputs for row in self.rows.values())

    def markdown(self) -> str:
        """Return the counts as a table."""
        lines = [
            "| reader | inputs | whole commands | accepted | refused | failed | longest, s | largest, MB |",
            "|---|---:|---:|---:|---:|---:|---:|---:|",
        ]
        every = Row()
        for name, r in self.rows.items():
            lines.append(_line(name, r))
            for key in ("inputs", "commands", "accepted", "refused", "failed"):
                setattr(every, key, getattr(every, key) + getattr(r, key))
            every.longest, every.largest = max(every.longest, r.longest), max(every.largest, r.largest)
        return "\n".join([*lines, _line("all", every)])


def _line(name: str, r: Row) -> str:
    counts = f"{r.inputs:,} | {r.commands:,} | {r.accepted:,} | {r.refused:,} | {r.failed:,}"
    return f"| {name} | {counts} | {r.longest:.2f} | {r.largest:.0f} |"
