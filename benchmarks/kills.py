"""Every long command killed by SIGKILL, SIGTERM and SIGINT at 20 moments by chance: `python -m benchmarks kills`.

SIGKILL and every second SIGTERM go to the command alone, the others to its whole group, as a terminal's Ctrl-C does. A
command is given again afterwards unless the kill left nothing at all, which makes the next call a first one. An hour.
`python -m benchmarks.kills NAME ...` does some commands.
"""

import signal
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks.table import Row
from imubench.proof.case import make_case
from tests.faults.commands import CLAIMS, COMMANDS, SWEEP, given
from tests.faults.kills import SIGNALS, Kills, moments, summary

MOMENTS = 20  # of each command and signal
SLOWER = "import time\ntime.sleep(1)\n"  # a diagnosis that is there to be killed
LONGER = {
    "run": "run hinge-hand --estimator olsson2020 --out out",
    "estimate": "estimate olsson2020 {given}/minute --out out",
    "convert csv": "convert csv {given}/table.csv --option rig=free --out out",
    "diagnose": "diagnose {given}/pendulum --out out",
    "reproduce": COMMANDS["reproduce"].words,  # of a paper whose parts take a second
    "generate, 2 workers": "generate {given}/spec.toml --count 60 --seed 3 --workers 2 --out out",
    "sweep": "sweep {given}/wide.toml --estimator seel2012 --workers 2 --out out",
    "check, 2 workers": "check {given}/close.toml --workers 2 --runs 300 --out out",
    "export opensim": "export opensim {given}/dataset --out out",
    "prove": "prove --cases 3 --seed 5 --seconds 6 --workers 2 --out out --diagnosis",
}
"""Words of the commands, longer than for faults so that there is work to be killed."""


def to_group(sent: signal.Signals, number: int) -> bool:
    """Return whether the kill of this number goes to the whole group."""
    return sent == signal.SIGINT or (sent == signal.SIGTERM and number % 2 == 1)


def run(names: Sequence[str] = ()) -> list[Row]:
    """Return a row for each command and signal."""
    rows = []
    with TemporaryDirectory() as temporary:
        home = Path(temporary).resolve()
        made = given(home / "given")
        make_case(made / "minute", "hinge", [], 5, seconds=60.0)
        (made / "wide.toml").write_text(SWEEP.replace("recordings = 1\n", "recordings = 30\n"))
        (made / "close.toml").write_text(CLAIMS.replace('"5 deg"', '"0.1 deg"'))
        program = made / "silent.py"
        program.write_text(SLOWER + program.read_text())
        for number, name in enumerate(names or LONGER):
            command = replace(COMMANDS[name], words=LONGER[name])
            kills = Kills(command, made, home / str(number))
            for sent in SIGNALS:
                done = [kills.kill(sent, t, to_group(sent, i)) for i, t in enumerate(moments(kills, MOMENTS, sent))]
                wrong = [d for d in done if d.wrong]
                for d in wrong:
                    print(d, file=sys.stderr, flush=True)
                again = sum(d.again for d in done)
                what = f"{name} ({kills.seconds:.0f} s), {sent.name} at {len(done)} moments: {summary(done)}"
                ours = f"{len(wrong)} not as promised, {again} gone on with"
                rows.append(Row(what, ours, "-", "-", "0", not wrong))
                print(rows[-1], file=sys.stderr, flush=True)
    return rows


if __name__ == "__main__":
    for row in run(sys.argv[1:]):
        print(f"| {row.what} | {row.ours} | {row.peer} | {row.ratio} | {row.required} | {row.met} |", flush=True)
