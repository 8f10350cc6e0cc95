"""How long a diagnosis takes as recordings grow, and how much memory.  python -m benchmarks.diagnosis_growth

A hinge with two IMUs and one left-out effect, a gyroscope's scale, by the independent generator; each length in a
process of its own, time on two cores, the report in it. Linear growth is a ratio of 1, of processor time.
"""

import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from benchmarks.table import Row
from imubench.proof.case import make_case

LENGTHS = (30.0, 60.0, 120.0, 240.0)  # s at 100 Hz
LONG, LONG_RATE = 700.0, 50.0
MOST_SECONDS, MOST_LONG, MOST_MEMORY = 60.0, 300.0, 2.0  # s, s, GB
STRAIGHT = 1.25  # of a time that grows with the length


def measured(seconds: float, rate: float) -> tuple[float, float, float]:
    """Return seconds, processor seconds and GB of a whole `imubench diagnose`."""
    with tempfile.TemporaryDirectory() as scratch:
        make_case(Path(scratch) / "r", "hinge", [("gyro_scale", "imu1")], 5, seconds=seconds, rate=rate)
        run = subprocess.run(
            [sys.executable, "-m", "benchmarks.diagnosis_growth", scratch], capture_output=True, text=True, check=True
        )
        took, spent, memory = (float(x) for x in run.stdout.split()[-3:])
    return took, spent, memory


def run() -> list[Row]:
    """Return the rows: time against length, memory, and the two lengths with a limit."""
    found = {seconds: measured(seconds, 100.0) for seconds in LENGTHS}
    took, _, memory = measured(LONG, LONG_RATE)
    growth = (found[LENGTHS[-1]][1] / LENGTHS[-1]) / (found[60.0][1] / 60.0)
    times = ", ".join(f"{found[s][0]:.0f}" for s in LENGTHS)
    sizes = ", ".join(f"{found[s][2]:.2f}" for s in LENGTHS)
    most = max(memory, *(m for *_, m in found.values()))
    one = found[60.0][0]
    return [
        Row(
            "diagnosis with one effect and report, 30, 60, 120, 240 s at 100 Hz, two cores; processor time per second, "
            "240 beside 60 s",
            f"{times} s",
            "-",
            f"{growth:.2f}",
            f"<= {STRAIGHT:g}",
            growth <= STRAIGHT,
        ),
        Row("the same of 60 s", f"{one:.0f} s", "-", "-", f"<= {MOST_SECONDS:g} s", one <= MOST_SECONDS),
        Row("the same, 700 s at 50 Hz", f"{took:.0f} s", "-", "-", f"<= {MOST_LONG:g} s", took <= MOST_LONG),
        Row(
            "the same, largest memory of 30, 60, 120, 240 s at 100 Hz and of 700 s at 50 Hz",
            f"{sizes}, {memory:.2f} GB",
            "-",
            "-",
            f"< {MOST_MEMORY:g} GB",
            most < MOST_MEMORY,
        ),
    ]


def _one(scratch: Path) -> None:
    from imubench.cli import app

    begin, spent = time.perf_counter(), time.process_time()
    app(["diagnose", str(scratch / "r"), "--out", str(scratch / "out")], standalone_mode=False)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6  # kB on Linux
    print(time.perf_counter() - begin, time.process_time() - spent, peak)


if __name__ == "__main__":
    if len(sys.argv) > 1:
        _one(Path(sys.argv[1]))
    else:
        print(*run(), sep="\n")
