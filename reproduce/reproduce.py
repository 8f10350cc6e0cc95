"""From the name of a paper to claims.json and report.html."""

import platform
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from pathlib import Path

import imubench
from imubench.answers import write_json
from imubench.atomic import atomic_directory
from imubench.attempt import own_apart
from imubench.errors import unknown
from imubench.leftovers import undone
from imubench.reproduce import PAPERS, beside
from imubench.reproduce.claims import Judged, judge
from imubench.reproduce.paper import Part
from imubench.reproduce.parts import Report, Store, run_parts, settings_text
from imubench.reproduce.report import page, require_matplotlib
from imubench.workers import cores

Watch = Callable[[list[Part]], AbstractContextManager[Report]]
"""Takes all parts; the context reports each one that is done."""


@dataclass(frozen=True)
class Reproduced:
    """What came of a paper, and of the estimators beside its own method."""

    judged: list[Judged]
    beside: str = ""  # a sentence about the estimators that were asked for


def reproduce(
    name: str,
    out: Path,
    quick: bool,
    seed: int,
    watch: Watch,
    workers: int | None = None,
    estimators: Sequence[str] = (),
    seconds: float | None = None,
) -> Reproduced:
    """Reproduce a paper into the folder `out`: claims.json and report.html; return the judged claims.

    With `estimators` each of them is also given the paper's recordings, beside the paper's own method: a table of the
    report, and beside.json. One that has not answered after so many `seconds` by the clock hangs. Claims are about the
    paper's method whatever stands beside it.

    What is finished stays in a hidden folder beside `out` until everything is: the same call goes on from there.
    Raises `InputError` for an unknown paper or estimator, without matplotlib, or where `out` cannot be written.
    """
    if name not in PAPERS:
        raise unknown("paper", name, PAPERS)
    require_matplotlib()
    paper = PAPERS[name]
    settings = paper.settings(quick, seed)
    asked = beside.asked_for(paper, settings, estimators, seconds)
    files = [Path(place.rpartition(":")[0]) for place in (asked.places.values() if asked else ())]
    with undone(own_apart().end), atomic_directory(out, [file for file in files if file.suffix == ".py"]) as folder:
        parts = [*paper.parts(settings), *(beside.parts(asked) if asked else ())]
        decided = settings if asked is None else (settings, asked.identity)
        store = Store(out, settings_text(decided, quick))
        with watch(parts) as report:
            done = run_parts(parts, store, cores() if workers is None else workers, report)
        results = paper.gather(settings, done)
        judged = [judge(claim, paper.measures[claim.measure](results)) for claim in paper.claims]
        write_json(folder / "claims.json", [j.as_dict() for j in judged])
        length = "Quick run: less of everything than the paper's." if quick else "Full run."
        how = f"{length} Seed {seed}."
        command = f"imubench reproduce {name}{' --quick' if quick else ''} --seed {seed}"
        command += "".join(f" --estimator {one}" for one in estimators)
        story, told = paper.tell(results), ""
        if asked is not None:
            found = beside.outcomes(asked, done)
            write_json(folder / "beside.json", beside.as_list(asked, found))
            story = replace(story, exhibits=(*story.exhibits, beside.table(asked, found)))
            told = beside.finding(asked, found)
        footer = (
            f"imubench {imubench.__version__}: {command}, on {platform.machine()} with Python "
            f"{platform.python_version()}. Bounds come from claims.toml beside the code; hold the pointer over a bound "
            "to see where it comes from."
        )
        (folder / "report.html").write_text(page(paper, story, judged, how, footer), encoding="utf-8")
    store.forget()
    return Reproduced(judged, told)
