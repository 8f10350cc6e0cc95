"""How long every figure, table and claim of a paper takes again, on all cores."""

import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter

from benchmarks.table import Row

LIMITS = {"olsson2020": 600.0, "arve": 180.0}  # s, of the full run
QUICK = 60.0  # s


def run() -> list[Row]:
    """Return the wall time of each paper, in full and quick."""
    rows = []
    for paper, limit in LIMITS.items():
        for words, most in (([], limit), (["--quick"], QUICK)):
            with tempfile.TemporaryDirectory() as out:
                command = [Path(sys.executable).with_name("imubench"), "reproduce", paper, *words, "--out", out]
                begin = perf_counter()
                done = subprocess.run(command, capture_output=True, check=False)
                took = perf_counter() - begin
                if done.returncode not in (0, 1):  # 1: a claim fails, which is a result
                    raise RuntimeError(done.stderr.decode(errors="replace"))
            what = " ".join(["imubench reproduce", paper, *words])
            rows.append(Row(f"`{what}`, all cores", f"{took:.0f} s", "-", "-", f"< {most:.0f} s", took < most))
    return rows
