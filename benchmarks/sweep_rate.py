"""How long a sweep takes: frequency x damping of a soft mount, three estimators, 12 x 8 cells x 20 recordings.

Minutes of two cores: run by name alone, `python -m benchmarks sweep_rate`.
"""

import os
import subprocess
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks.table import Row

FOLDER = Path(__file__).parent / "your_tissue"
ESTIMATORS = ("seel2012", "olsson2020", "mine.py:estimate")  # the last from outside the package
WORKERS = 2
ALLOWED = 300.0  # s by the clock, on two cores with nothing else on them


def run() -> list[Row]:
    """Make the sweep of docs/your-tissue.md; processor time divided by the workers is what idle cores would take."""
    with TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "imubench", "sweep", "sweep.toml", "--workers", str(WORKERS)]
        command += [word for name in ESTIMATORS for word in ("--estimator", name)]
        begun = time.monotonic()
        process = subprocess.Popen([*command, "--out", f"{folder}/out"], cwd=FOLDER)
        _, status, used = os.wait4(process.pid, 0)
        wall, cpu = time.monotonic() - begun, used.ru_utime + used.ru_stime
    if status:
        raise RuntimeError(f"the sweep ended with status {status}")
    what = "sweep, frequency x damping of a soft mount, 12 x 8 cells x 20 recordings of 10 s, three estimators"
    each = cpu / (12 * 8 * 20)
    ours = f"{wall:.0f} s, {cpu:.0f} s of processor time, {each:.2f} s a recording"
    return [Row(f"{what}, {WORKERS} workers", ours, "-", "-", f"< {ALLOWED:.0f} s", wall < ALLOWED)]
