"""A sweep is made, or gone on with: pieces in any order, each kept when it is finished; the result last."""

import json
import platform
from collections.abc import Mapping, Sequence
from contextlib import closing
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

import imubench
from imubench.answers import write_json
from imubench.arrays import Array
from imubench.atomic import atomic_directory
from imubench.dataset.engines import ENGINES
from imubench.errors import InputError, unknown
from imubench.estimators import Estimator
from imubench.leftovers import undone
from imubench.plugin_versions import absolute, versions
from imubench.plugins import find_estimator
from imubench.progress import Report
from imubench.reproduce.parts import Store
from imubench.reproduce.report import require_matplotlib
from imubench.sweeps import attempts
from imubench.sweeps.cells import Cell, Map, cells, maps
from imubench.sweeps.figures import figure_of
from imubench.sweeps.finding import finding, headline
from imubench.sweeps.outside import as_table
from imubench.sweeps.page import page
from imubench.sweeps.spec import SWEEP_FILE, Sweep
from imubench.sweeps.tables import write_tables
from imubench.sweeps.work import COMPUTING, Outcome, Piece, SweepWork

SECONDS = 60.0
"""s that an estimate may take, if nothing else is said: a hundred times what the slowest of ours takes for 10 s."""


def sweep(
    asked: Sweep,
    estimators: Sequence[str],
    out: Path,
    seed: int = 0,
    workers: int | None = None,
    engine: str = "local",
    address: str | None = None,
    seconds: float = SECONDS,
    inputs: Sequence[Path] = (),
    report: Report = lambda *_: None,
) -> list[Cell]:
    """Make a sweep into a folder and return every cell of every estimator.

    Written are sweep.parquet and sweep.csv (a row a cell and estimator), recordings.parquet (a row a recording and
    estimator), sweep.json, report.html and a copy of the spec. What is finished stays in a hidden folder beside `out`
    until everything is: the same call goes on from there, to the same bytes.

    Args:
        asked: of `load_sweep`.
        estimators: as `--estimator` takes them.
        out: the folder.
        seed: the same seed gives the same recordings.
        workers: processes; None: one a core, 0: this one alone.
        engine: local or ray.
        address: of the Ray cluster.
        seconds: s by the clock that an estimate may take.
        inputs: files that are read, which `out` must be apart from.
        report: told of progress.

    Raises:
        InputError: an estimator, engine or figure that is none, two quantities, or an output that cannot be written.
    """
    if engine not in ENGINES:
        raise unknown("engine", engine, ENGINES)
    require_matplotlib()
    ENGINES[engine].check(workers, address)
    names = list(dict.fromkeys(estimators))
    work = _work(asked, names, out, seed, seconds)
    identity = work.identity()
    with undone(attempts.end), atomic_directory(out, inputs) as folder:
        store = Store(out, json.dumps(identity), COMPUTING)
        outcomes = _outcomes(work, store, workers, engine, address, report)
        done = cells(asked, names, outcomes)
        drawn = maps(asked, names, done)
        write_tables(folder, asked, work.figure, done, outcomes)
        for name, content in asked.content.items():
            (folder / "spec" / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / "spec" / name).write_bytes(content)
        write_json(folder / "sweep.json", _told(work, identity, asked, drawn))
        text = page(asked, work.figure, done, drawn, outcomes, _footer(names, seed, asked))
        (folder / "report.html").write_text(text, encoding="utf-8")
    store.forget()
    return done


def _work(asked: Sweep, names: Sequence[str], out: Path, seed: int, seconds: float) -> SweepWork:
    if not names:
        raise InputError("--estimator: expected one or more, got none")
    if not seconds > 0:
        raise InputError(f"seconds: expected more than 0, got {seconds:g}")
    methods = [find_estimator(name) for name in names]
    _check_imus(asked, methods)
    places = {name: absolute(name) for name in names}
    return SweepWork(
        asked.content,
        asked.recordings,
        places,
        versions(places),
        figure_of(asked.figure, methods, asked.score_unit),
        seconds,
        seed,
        str(out),
    )


def _check_imus(asked: Sweep, methods: Sequence[Estimator]) -> None:
    for rig in asked.cell(0, 0).rigs:
        have = len(rig.tree.imus)
        for method in methods:
            if method.imus > have:
                raise InputError(f"{method.name}: expected a rig of {method.imus} IMUs, got a {rig.family} of {have}")


def _outcomes(
    work: SweepWork, store: Store, workers: int | None, engine: str, address: str | None, report: Report
) -> list[Outcome]:
    pieces: dict[int, Piece] = {}
    for number in range(work.pieces):
        kept = store.load(_name(number))
        piece = None if kept is None else _piece(number, kept)
        if piece is not None:
            pieces[number] = piece
    left = [number for number in range(work.pieces) if number not in pieces]
    width = work.sweep.shape[0]
    report("recordings", len(pieces) * width, work.pieces * width)
    with closing(ENGINES[engine].run(work, left, workers, address)) as made:
        for piece in made:
            store.save(_name(piece.number), _arrays(piece))
            pieces[piece.number] = piece
            report("recordings", len(pieces) * width, work.pieces * width)
    return list(chain.from_iterable(pieces[number].outcomes for number in range(work.pieces)))


def _name(number: int) -> str:
    return f"piece-{number:06d}"


COLUMNS = ("row", "column", "recording", "estimator", "outcome", "error", "best_pairing", "why")


def _arrays(piece: Piece) -> dict[str, Array]:
    """Return a piece as columns."""
    rows = [
        (*o.cell, o.recording, o.estimator, o.outcome, np.nan if o.error is None else o.error, o.best_pairing, o.why)
        for o in piece.outcomes
    ]
    return {name: np.array(column) for name, column in zip(COLUMNS, zip(*rows, strict=True), strict=True)}


def _piece(number: int, arrays: Mapping[str, Array]) -> Piece | None:
    """Return a piece from its columns; None where they are not what we write."""
    if set(arrays) != set(COLUMNS) or len({a.shape for a in arrays.values()}) != 1 or arrays["row"].ndim != 1:
        return None
    outcomes = [
        Outcome((row, column), recording, estimator, outcome, None if np.isnan(error) else error, best, why)
        for row, column, recording, estimator, outcome, error, best, why in zip(
            *(arrays[name].tolist() for name in COLUMNS), strict=True
        )
    ]
    return Piece(number, tuple(outcomes))


IDENTITY = ("spec", "recordings", "seed", "seconds", "versions", "peers", "code", "machine")


def _told(work: SweepWork, identity: Mapping[str, Any], asked: Sweep, drawn: list[Map]) -> dict[str, Any]:
    axes = [
        {"parameters": [p.text for p in a.parameters], "label": a.label, "unit": a.unit, "scale": a.scale}
        | {"values": list(a.values), "in_spec": list(a.in_spec)}
        for a in asked.axes
    ]
    return {
        "format": 1,
        "kind": "imubench sweep",
        "name": asked.name,
        "axes": axes,
        "figure": work.figure,
        "quantile": asked.quantile,
        "limit": {"value": asked.limit, "unit": asked.unit},
        "headline": headline(asked, drawn),
        "findings": {m.estimator: finding(asked, m) for m in drawn},
        **{
            key: identity[key]
            for key in ("spec", "rig_files", "recordings", "seed", "seconds", "versions", "peers", "code", "machine")
            if key in identity
        },
        "estimators": as_table(list(work.estimators), work.prints),
    }


def _footer(names: Sequence[str], seed: int, asked: Sweep) -> str:
    given = " ".join([*(f"--estimator {name}" for name in names), f"--recordings {asked.recordings}"])
    return (
        f"imubench {imubench.__version__}: imubench sweep {SWEEP_FILE} {given} --seed {seed}, on {platform.machine()} "
        f"with Python {platform.python_version()}. Every number is in sweep.parquet and sweep.csv, every recording's "
        "in recordings.parquet."
    )
