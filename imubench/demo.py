"""The main job in one go: a simulated rig, recordings from disk, real ones where they are at hand, and a diagnosis.

Real recordings are looked for in the folder named by the environment variable IMUBENCH_DATA.
"""

import os
import re
import sys
from collections.abc import Iterator, Sequence
from importlib.resources import as_file, files
from pathlib import Path

import numpy as np
from rich.box import SIMPLE
from rich.table import Table

from imubench import concealed
from imubench.convert import CONVERTERS
from imubench.format1 import write_recording
from imubench.picture import draw_run
from imubench.progress import Step, on_console
from imubench.run import NoEstimateError, estimate_on_disk, run_scenario
from imubench.score import Score
from imubench.terminal import Terminal

Row = tuple[str, str, str, Score | None, str]
ESTIMATORS_SHOWN = ("olsson2020", "seel2012")


def simulated(names: Sequence[str], out: Path, step: Step) -> Iterator[Row]:
    """Run a hinge rig through every estimator."""
    for name in names:
        done = run_scenario("hinge-hand", out / f"hinge-hand-{_plain(name)}", name, step=step)
        if done.failed is not None or done.estimate is None or done.score is None:
            yield "hinge, simulated", name, done.failed.status if done.failed else "none", None, "truth"
            continue
        if name == ESTIMATORS_SHOWN[0]:
            draw_run(out / "hinge-hand.png", done.recording, done.estimate, done.score)
        yield "hinge, simulated", name, done.estimate.status, done.score, "truth"


def from_disk(names: Sequence[str], folder: Path, title: str, out: Path, step: Step) -> Iterator[Row]:
    """Estimate on a recording in format 1 with every estimator."""
    for name in names:
        try:
            done = estimate_on_disk(name, folder, out / f"{folder.name}-{_plain(name)}", step)
        except NoEstimateError as error:
            yield title, name, error.failed.status, None, "reference"
            continue
        yield title, name, done.estimate.status, done.beside_reference, "reference"


def real(names: Sequence[str], data: Path, out: Path, step: Step) -> Iterator[Row]:
    """Convert the real hinge recordings and estimate on them."""
    for segments in ("3-4", "4-5"):
        for imu in ("rigid", "nonrigid"):
            with step(f"convert DIODEM {segments} {imu}"):
                (converted,) = CONVERTERS["diodem"](data / "diodem" / "trial1", segments=segments, imu=imu)
                folder = out / "recordings" / f"diodem-{segments}-{imu}"
                write_recording(converted.recording, folder, converted.reference)
            yield from from_disk(names, folder, f"DIODEM {segments}, {imu}", out, step)


def main(out: Path = Path("demo"), more: Sequence[str] = ()) -> None:
    """Run everything, print what came out, and say where the results are; `more` names estimators beside ours."""
    console, errors = Terminal(), Terminal(stderr=True)
    step = on_console(errors)
    estimates((*ESTIMATORS_SHOWN, *more), out, console, step)
    concealed.show(out / "concealed", console, errors, step)


def estimates(names: Sequence[str], out: Path, console: Terminal, step: Step) -> None:
    """Estimate hinge axes from simulated and real recordings, and print one table."""
    rows = list(simulated(names, out, step))
    with as_file(files("imubench.scenarios") / "demo_recording") as folder:
        rows += from_disk(names, folder, "demo, from disk", out, step)
    data = os.environ.get("IMUBENCH_DATA")
    if data and (Path(data) / "diodem").is_dir():
        rows += real(names, Path(data), out, step)
    title = "Angle in deg between the estimated hinge axis and the one it is judged by"
    table = Table(title=title, title_justify="left", box=SIMPLE, padding=(0, 1, 0, 0))
    for column in ("recording", "estimator", "status", "imu1", "imu2", "against"):
        number = column.startswith("imu")
        table.add_column(column, justify="right" if number else "left", no_wrap=True, min_width=5 if number else None)
    for title, name, status, score, judge in rows:
        values = ["-", "-"] if score is None else [_degrees(score, imu) for imu in ("imu1", "imu2")]
        table.add_row(title, name, status, *values, judge)
    console.print(table)
    if any(score is not None and score.pairing == "unknown" for _, _, _, score, _ in rows):
        console.print("* sign pairing unknown: of the better pairing")
    if not data:
        console.print("Real recordings: set IMUBENCH_DATA to their folder to see them here too.")
    console.print(
        f"A picture: {out / 'hinge-hand.png'}    In 3D: rerun {out / 'hinge-hand-olsson2020' / 'run.rrd'}",
        soft_wrap=True,
    )


def _plain(name: str) -> str:
    """Return an estimator's name as one of a folder."""
    return re.sub(r"[^\w.+-]+", "-", Path(name).name)


def _degrees(score: Score, imu: str) -> str:
    angle = score.deviation(imu)
    return "-" if angle is None else f"{np.rad2deg(angle):.2f}" + ("*" if score.pairing == "unknown" else "")


if __name__ == "__main__":
    main(more=sys.argv[1:])
