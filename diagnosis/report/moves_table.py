"""What the findings move, finding by finding: by the motion fit, and by the project's estimators."""

from collections.abc import Sequence

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.evidence import Estimated, Evidence
from imubench.diagnosis.report import words
from imubench.diagnosis.report.html import table, term
from imubench.diagnosis.report.numbers import fixed
from imubench.diagnosis.result import Diagnosis, Move, Moves
from imubench.reproduce.report import escape

DASH = "–"
QUANTITIES = {"joint_axis": "joint axis", "joint_vector": "joint centre"}
AS_IT_CAME, TAKEN_OUT = "as it came", "without what was found"

Row = tuple[str, ...]


def moves_table(d: Diagnosis, evidence: Evidence, shown: Sequence[int]) -> str:
    """Return a table of what findings move, and how far estimates are from a reference; empty where nothing is known.

    Args:
        d: what was found.
        evidence: with what the estimators make of the recording.
        shown: the places in `d.findings` of those that are numbered on the page, in that order.
    """
    known = [i for i in shown if d.findings[i].moves or any(e.each[i] is not None for e in evidence.estimates)]
    together = len(d.findings) > 1 and bool(d.moves or evidence.estimates)
    if not known and not together:
        return ""
    body = [*_of_the_fit(d, known, together)]
    for e in evidence.estimates:
        cells = [_numbers(e.each[i], e.unit) for i in known] + ([_numbers(e.moved, e.unit)] if together else [])
        whose = f" of {words.listed(list(e.imus))}" if len(e.imus) > 1 else ""
        body.append((f"{QUANTITIES[e.quantity]}{whose}, by {e.estimator} ({e.unit})", *cells))
    heads = [f"finding {shown.index(i) + 1}" for i in known] + (["all together"] if together else [])
    said = (
        "How much farther off a result is without a finding, beside the fitted motion; how much it changes, by an "
        "estimator that is named:"
    )
    parts = [_reference(e) for e in evidence.estimates if e.off is not None]
    parts += [f"<p>{said}</p>", table(("what", *heads), body, last=len(heads) + 1)]
    parts += [_status(e) for e in evidence.estimates if set(e.status) != {"converged"}]
    return f"<div class='moved'>{''.join(parts)}</div>"


def _of_the_fit(d: Diagnosis, known: Sequence[int], together: bool) -> list[Row]:
    """Return the rows of what the fitted motion moves."""
    columns: list[Moves] = [d.findings[i].moves for i in known] + ([d.moves] if together else [])
    names = list(dict.fromkeys(name for moves in columns for name in moves))
    return [(_called(columns, name), *(_cell(moves.get(name)) for moves in columns)) for name in names]


def _called(columns: Sequence[Moves], name: str) -> str:
    """Return a row's name: what is moved, of which sensors or segments, and the unit."""
    move = next(moves[name] for moves in columns if name in moves)
    of = "segment " if name == "orientation" else "imu"
    whose = f" of {words.listed([f'{of}{k + 1}' for k in range(move.value.size)])}" if move.value.size > 1 else ""
    return f"{words.MOVED_WORDS.get(name, name)}{whose} ({move.unit})"


def _cell(move: Move | None) -> str:
    return DASH if move is None else _numbers(move.value, move.unit)


def _numbers(values: Array | None, unit: str) -> str:
    if values is None:
        return DASH
    return ", ".join(fixed(float(x), 1 if unit.startswith("mm") else 2) for x in np.ravel(values))


def _status(e: Estimated) -> str:
    text = f"{e.estimator} calls its answer {e.status[0]} on the recording {AS_IT_CAME}, {e.status[1]} {TAKEN_OUT}."
    return f"<p class='soft small'>{escape(text)}</p>"


def _reference(e: Estimated) -> str:
    """Return how far an estimator's axes are from the reference's, as the recording came and without the findings."""
    assert e.off is not None
    pairs = zip(e.imus, *e.off, strict=True)
    changes = [f"<b>{_numbers(was, e.unit)} → {_numbers(now, e.unit)}</b> {e.unit} at {imu}" for imu, was, now in pairs]
    return (
        f"<p>Against the {term('reference')}, the {QUANTITIES[e.quantity]} by {escape(e.estimator)} is off by "
        f"{words.listed(changes)} ({AS_IT_CAME} → {TAKEN_OUT}).</p>"
    )


__all__ = ["moves_table"]
