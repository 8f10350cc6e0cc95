"""Every write of every command made to fail, and what follows: `python -m benchmarks faults`, an hour of one core.

A row is a command: how many calls it makes that write, how many faults were injected into them, and how many of these
were not met as promised (one line, nothing half-written, the same command comes to the same bytes afterwards).
"""

import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks.table import Row
from tests.faults.commands import COMMANDS
from tests.faults.injection import Injections


def run() -> list[Row]:
    rows = []
    with TemporaryDirectory() as temporary:
        injections = Injections(Path(temporary).resolve())
        for name in COMMANDS:
            one = injections.into(name)
            done = [one.trial(at, fault) for at, fault in one.plan()]
            wrong = [d for d in done if d.wrong]
            for d in wrong:
                print(d, file=sys.stderr, flush=True)
            places = len(one.places())
            what = f"{name}: {len(one.first.calls)} calls that write, faults at {places}"
            rows.append(Row(what, f"{len(wrong)} of {len(done)} not as promised", "-", "-", "0", not wrong))
            print(rows[-1], file=sys.stderr, flush=True)
        injections.warm.close()
    return rows
