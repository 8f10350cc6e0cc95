"""What a map shows, in a sentence: from where on, and up to where, an estimator keeps the limit."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from imubench.sweeps.axis import Axis, printed
from imubench.sweeps.cells import Map
from imubench.sweeps.spec import Sweep


@dataclass(frozen=True)
class Run:
    """Where along the first axis the limit is kept, in one row: everywhere between two places."""

    low: float | None  # None: from the first value on
    high: float | None  # None: up to the last


def finding(sweep: Sweep, found: Map) -> str:
    """Return one sentence; a recording that cannot be played counts as an infinite error."""
    below = found.below(sweep.limit)
    limit = f"{sweep.limit:g} {sweep.unit}"
    what = "the median" if sweep.quantile == 0.5 else f"the {100 * sweep.quantile:g} % quantile"
    if below.all():
        return f"{found.estimator}: {what} of the error stays below {limit} in every cell"
    if not below.any():
        return f"{found.estimator}: {what} of the error is below {limit} in no cell"
    axis = sweep.axes[0]
    runs = [] if axis.is_text else [_run(axis, found, below[:, j], j, sweep.limit) for j in range(below.shape[1])]
    rows = [] if any(run == "many" for run in runs) else [run for run in runs if isinstance(run, Run)]
    sides = {(run.low is None, run.high is None) for run in rows} - {(True, True)}
    if not rows or len(sides) > 1:
        return f"{found.estimator}: {what} of the error is below {limit} in {below.sum()} of {below.size} cells"
    if len(sweep.axes) == 1:
        return f"{found.estimator}: {what} of the error stays below {limit} {_words(axis, rows[0])}"
    return f"{found.estimator}: {what} of the error stays below {limit} {_of_rows(sweep, runs)}"


def headline(sweep: Sweep, found: list[Map]) -> str:
    """Return how many cells each estimator keeps the limit in, the best first; of one alone what its map shows."""
    if len(found) == 1:
        return finding(sweep, found[0])
    counts = sorted(((int(m.below(sweep.limit).sum()), m.estimator) for m in found), key=lambda pair: -pair[0])
    (most, first), *others = counts
    told = [f"{first} in {most} of {found[0].value.size} cells", *(f"{name} in {count}" for count, name in others)]
    return f"Error below {sweep.limit:g} {sweep.unit}: {', '.join(told)}"


def crossing(axis: Axis, inside: tuple[float, float], outside: tuple[float, float], limit: float) -> float:
    """Return where an error passes the limit between two places of an axis, each (place, error).

    Interpolated in the logarithm of the error, and of the place on a logarithmic axis; where an error is no number or
    infinite nothing is interpolated, and the place inside counts.
    """
    (a, e), (b, f) = inside, outside
    if not (np.isfinite(e) and np.isfinite(f)) or e <= 0 or f <= e:
        return a
    part = float(np.log(limit / e) / np.log(f / e))
    if axis.scale == "log":
        return float(np.exp(np.log(a) + part * (np.log(b) - np.log(a))))
    return a + part * (b - a)


def _run(axis: Axis, found: Map, below: NDArray[np.bool_], row: int, limit: float) -> Run | str:
    """Return where a row keeps the limit; `none`, or `many` where it does so in more than one stretch."""
    inside = np.flatnonzero(below)
    if not inside.size:
        return "none"
    first, last = int(inside[0]), int(inside[-1])
    if inside.size != last - first + 1:
        return "many"
    places, values = axis.places, found.bound[:, row]

    def end(at: int, beyond: int) -> float:
        return crossing(axis, (places[at], values[at]), (places[beyond], values[beyond]), limit)

    return Run(None if first == 0 else end(first, first - 1), None if last == places.size - 1 else end(last, last + 1))


def _words(axis: Axis, run: Run) -> str:
    unit = f" {printed(axis.unit)}" if axis.unit else ""
    what = "" if axis.unit else f" of {axis.label}"
    if run.low is not None and run.high is not None:
        return f"from {run.low:.2g} to {run.high:.2g}{unit}{what}"
    if run.low is not None:
        return f"from {run.low:.2g}{unit}{what} up"
    if run.high is not None:
        return f"up to {run.high:.2g}{unit}{what}"
    return "everywhere"


def _of_rows(sweep: Sweep, runs: list[Run | str]) -> str:
    """Return the words of the rows with the widest and the narrowest stretch, and of those without one."""
    axis, other = sweep.axes
    told = [(_width(axis, run), j) for j, run in enumerate(runs)]
    widest = min(told, key=lambda pair: (-pair[0], pair[1]))[1]
    narrowest = min(told)[1]

    def at(j: int) -> str:
        return f"{other.label} {other.shown(other.values[j])}"

    def said(j: int) -> str:
        run = runs[j]
        return _words(axis, run) if isinstance(run, Run) else "nowhere"

    step = _width(axis, Run(None, None)) / (axis.places.size - 1)
    if isinstance(runs[narrowest], Run) and _width(axis, runs[widest]) - _width(axis, runs[narrowest]) < step:
        return f"{said(narrowest)}, whatever the {other.label}"  # no more than a cell apart
    return f"{said(widest)} at {at(widest)}, and {said(narrowest)} at {at(narrowest)}"


def _width(axis: Axis, run: Run | str) -> float:
    if not isinstance(run, Run):
        return 0.0
    scale = np.log if axis.scale == "log" else np.asarray
    low = axis.places[0] if run.low is None else run.low
    high = axis.places[-1] if run.high is None else run.high
    return float(scale(high) - scale(low))
