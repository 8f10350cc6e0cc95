"""`imubench sweep`: a bar of what is done, what each estimator comes to, one line for what is wrong."""

from pathlib import Path

from imubench.progress import bars
from imubench.signals import promising
from imubench.sweeps.cells import maps
from imubench.sweeps.finding import finding, headline
from imubench.sweeps.run import sweep
from imubench.sweeps.spec import SWEEP_FILE, load_sweep
from imubench.terminal import Terminal


def run(
    spec: Path,
    estimators: list[str],
    seed: int,
    recordings: int | None,
    seconds: float,
    workers: int | None,
    engine: str,
    address: str | None,
    out: Path | None,
    console: Terminal,
    errors: Terminal,
) -> None:
    """Make a sweep into `out` and print what it shows."""
    asked = load_sweep(spec, recordings)
    target = out or Path("runs") / asked.name
    inputs = [spec, *(spec.parent / name for name in asked.content if name != SWEEP_FILE)]
    inputs += [Path(name.rpartition(":")[0]) for name in estimators if name.rpartition(":")[0].endswith(".py")]
    kept = "what was finished is kept beside --out: the same command goes on from there"
    with promising(kept), bars(errors) as report:
        cells = sweep(asked, estimators, target, seed, workers, engine, address, seconds, inputs, report)
    drawn = maps(asked, list(dict.fromkeys(estimators)), cells)
    console.say(headline(asked, drawn), "bold")
    for m in drawn if len(drawn) > 1 else ():
        console.say(f"  {finding(asked, m)}")
    console.say(f"written: {target}; open {target / 'report.html'}")
