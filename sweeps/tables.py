"""A sweep as tables: a row a cell and estimator, and a row a recording and estimator. Axes are in the spec's units."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.csv as pa_csv
import pyarrow.parquet as pq

from imubench.sweeps.cells import QUANTILES, Cell
from imubench.sweeps.spec import Sweep
from imubench.sweeps.work import ANSWERED, Outcome
from imubench.units import SHOWN

FAILURES = ("crashed", "timed out", "malformed", "refused")
CELLS, CELLS_CSV, RECORDINGS = "sweep.parquet", "sweep.csv", "recordings.parquet"


def write_tables(folder: Path, sweep: Sweep, figure: str, found: Sequence[Cell], outcomes: Sequence[Outcome]) -> None:
    """Write sweep.parquet, sweep.csv and recordings.parquet into a folder."""
    table = cells_table(sweep, figure, found)
    _write_parquet(table, folder / CELLS)
    with (folder / CELLS_CSV).open("wb") as file:
        pa_csv.write_csv(table, file)
    _write_parquet(recordings_table(sweep, outcomes), folder / RECORDINGS)


def cells_table(sweep: Sweep, figure: str, found: Sequence[Cell]) -> Any:
    """Return a row a cell and estimator: the axes' values, how many answers, the error's quantiles and interval."""
    rows = [_axes(sweep, c.at) | _cell(sweep, figure, c) for c in found]
    numbers = ("value", "value_low", "value_high", "failed_low", "failed_high", *(_quantile(q) for q in QUANTILES))
    counts = ("recordings", "played", "failed", *map(_column, FAILURES), *map(_column, ANSWERED), "best_pairing")
    schema = pa.schema(
        [
            *_axes_schema(sweep),
            ("estimator", pa.string()),
            ("figure", pa.string()),
            ("unit", pa.string()),
            *((name, pa.int64()) for name in counts),
            *((name, pa.float64()) for name in numbers),
        ]
    )
    return pa.Table.from_pylist(rows, schema)


def recordings_table(sweep: Sweep, outcomes: Sequence[Outcome]) -> Any:
    """Return a row a recording and estimator, in the order of the grid; errors in the unit of the limit."""
    factor = SHOWN[sweep.score_unit][1]
    order = {name: n for n, name in enumerate(dict.fromkeys(o.estimator for o in outcomes))}
    rows = [
        _axes(sweep, o.cell)
        | {"recording": o.recording, "estimator": o.estimator, "outcome": o.outcome, "why": o.why}
        | {"error": None if o.error is None else factor * o.error, "best_pairing": o.best_pairing}
        for o in sorted(outcomes, key=lambda o: (o.cell, o.recording, order[o.estimator]))
    ]
    texts = [(name, pa.string()) for name in ("estimator", "outcome")]
    rest = [("error", pa.float64()), ("best_pairing", pa.bool_()), ("why", pa.string())]
    return pa.Table.from_pylist(rows, pa.schema([*_axes_schema(sweep), ("recording", pa.int64()), *texts, *rest]))


def _axes_schema(sweep: Sweep) -> list[tuple[str, Any]]:
    return [(axis.name, pa.string() if axis.is_text else pa.float64()) for axis in sweep.axes]


def _axes(sweep: Sweep, at: tuple[int, int]) -> dict[str, Any]:
    return {axis.name: axis.in_spec[k] for axis, k in zip(sweep.axes, at, strict=False)}


def _cell(sweep: Sweep, figure: str, c: Cell) -> dict[str, Any]:
    told = bool(c.played)
    failed = c.failed_interval
    return {
        "estimator": c.estimator,
        "figure": figure,
        "unit": sweep.unit,
        "recordings": c.recordings,
        "played": c.played,
        "failed": c.failed,
        **{_column(name): c.outcomes.get(name, 0) for name in (*FAILURES, *ANSWERED)},
        "best_pairing": c.best_pairing,
        "value": c.value if told else None,
        "value_low": c.interval[0] if told else None,
        "value_high": c.interval[1] if told else None,
        "failed_low": failed[0] if told else None,
        "failed_high": failed[1] if told else None,
        **{_quantile(q): v if told else None for q, v in zip(QUANTILES, c.quantiles(), strict=True)},
    }


def _column(outcome: str) -> str:
    return outcome.replace(" ", "_")


def _quantile(q: float) -> str:
    return f"q{round(100 * q):02d}"


def _write_parquet(table: Any, path: Path) -> None:
    with path.open("wb") as file:
        pq.write_table(table, file, compression="zstd")
