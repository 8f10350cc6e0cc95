"""From the name of a paper to claims.json and report.html."""

import platform
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path

import imubench
from imubench.answers import write_json
from imubench.atomic import atomic_directory
from imubench.errors import unknown
from imubench.reproduce import PAPERS
from imubench.reproduce.claims import Judged, judge
from imubench.reproduce.paper import Part
from imubench.reproduce.parts import Report, Store, run_parts, settings_text
from imubench.reproduce.report import page, require_matplotlib
from imubench.workers import cores

Watch = Callable[[list[Part]], AbstractContextManager[Report]]
"""Takes all parts; the context reports each one that is done."""


def reproduce(name: str, out: Path, quick: bool, seed: int, watch: Watch, workers: int | None = None) -> list[Judged]:
    """Reproduce a paper into the folder `out`: claims.json and report.html; return the judged claims.

    What is finished stays in a hidden folder beside `out` until everything is: the same call goes on from there.
    Raises `InputError` for an unknown paper, where matplotlib is missing, or where `out` cannot be written.
    """
    if name not in PAPERS:
        raise unknown("paper", name, PAPERS)
    require_matplotlib()
    paper = PAPERS[name]
    with atomic_directory(out) as folder:
        settings = paper.settings(quick, seed)
        parts = paper.parts(settings)
        store = Store(out, settings_text(settings, quick))
        with watch(parts) as report:
            done = run_parts(parts, store, cores() if workers is None else workers, report)
        results = paper.gather(settings, done)
        judged = [judge(claim, paper.measures[claim.measure](results)) for claim in paper.claims]
        write_json(folder / "claims.json", [j.as_dict() for j in judged])
        length = "Quick run: less of everything than the paper's." if quick else "Full run."
        how = f"{length} Seed {seed}."
        command = f"imubench reproduce {name}{' --quick' if quick else ''} --seed {seed}"
        footer = (
            f"imubench {imubench.__version__}: {command}, on {platform.machine()} with Python "
            f"{platform.python_version()}. Bounds come from claims.toml beside the code; hold the pointer over a bound "
            "to see where it comes from."
        )
        (folder / "report.html").write_text(page(paper, paper.tell(results), judged, how, footer), encoding="utf-8")
    store.forget()
    return judged
