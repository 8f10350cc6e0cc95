"""Run every benchmark and write RESULTS.md: command, machine, date, ratio."""

import importlib
import os
import platform
import sys
from datetime import UTC, datetime
from pathlib import Path

from rich.console import Console

from benchmarks.table import Row

BENCHMARKS = (
    "arve",
    "coverage",
    "dataset_rate",
    "diagnosis_growth",
    "qmt_axis",
    "reproduction",
    "selection",
    "simulation_rate",
    "streaming",
)
BY_NAME = "\n## Run by name\n"
HEAD = """# Benchmarks

Each row is one run with both sides in it; machines are noisy, so the ratio counts and not the rate.

- command: `make bench`
- date: {date}
- machine: {cores} cores, {processor}, Python {python}, {system}

| what | ours | peer | ratio | required | met |
|---|---:|---:|---:|---:|---|
"""


def main(names: list[str]) -> int:
    """Run the named benchmarks, or all of BENCHMARKS; return 1 if a requirement is missed.

    `ablation`, `blind_cases`, `claim_checks`, `guard_table`, `dataset_runs`, `faint`, `faults`, `kills`, `silence`,
    `sweep_rate` and `sysid` take minutes each and run by name alone; their tables stand below the others.
    """
    console = Console(stderr=True)
    rows: list[Row] = []
    for name in names or BENCHMARKS:
        with console.status(f"benchmark {name} ..."):
            rows += importlib.import_module(f"benchmarks.{name}").run()
    text = HEAD.format(
        date=f"{datetime.now(UTC):%Y-%m-%d}",
        cores=os.cpu_count(),
        processor=processor(),
        python=platform.python_version(),
        system=platform.system(),
    )
    lines = [
        f"| {r.what} | {r.ours} | {r.peer} | {r.ratio} | {r.required} | {'yes' if r.met else '**no**'} |" for r in rows
    ]
    text += "\n".join(lines) + "\n"
    print(text)
    if not names:
        results = Path(__file__).parent / "RESULTS.md"
        _, named, kept = results.read_text(encoding="utf-8").partition(BY_NAME)
        results.write_text(text + named + kept, encoding="utf-8")
    return int(not all(r.met for r in rows))


def processor() -> str:
    """Return the name of this machine's processor."""
    info = Path("/proc/cpuinfo")
    if info.exists():
        for line in info.read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
