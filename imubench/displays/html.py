"""What a notebook shows of a value: what it is in a line, its numbers, and a small picture."""

from collections.abc import Callable, Iterable, Sequence
from html import escape
from typing import Any

import numpy as np

from imubench.diagnosis.result import Diagnosis
from imubench.displays.lines import line
from imubench.displays.numbers import told
from imubench.displays.svg import bars, traces
from imubench.estimate import Estimate
from imubench.recording import Recording
from imubench.score import Score
from imubench.truth import Truth

ROWS = 8  # of a table, at most


def page(value: Any) -> str:
    """Return HTML for a notebook; it loads nothing."""
    return f"<div>{PAGES[type(value)](value)}</div>"


def _recording(r: Recording) -> str:
    parts = [_line(line(r)[1:-1])]
    for imu in r.imus:
        parts.append(_line(f"{imu.name}: angular rate (rad/s), specific force (m/s²); x blue, y orange, z green"))
        parts += [traces(f"{imu.name} {key}", imu.time, getattr(imu, key)) for key in ("gyro", "accel")]
    return "<br>".join(parts)


def _truth(t: Truth) -> str:
    parts = [_line(line(t)[1:-1])]
    if t.joint_angle is not None:
        parts += [_line("hinge angle (rad)"), traces("hinge angle", t.time, t.joint_angle[:, None])]
    else:
        parts += [_line(f"{t.sensors[0].name}: true angular rate (rad/s)")]
        parts += [traces("angular rate", t.time, t.sensors[0].gyro)]
    return "<br>".join(parts)


def _estimate(e: Estimate) -> str:
    head = _line(f"Estimate of the {e.quantity} by {e.estimator}: {e.status}")
    if e.time is not None:
        sizes = np.linalg.norm(e.value, axis=-1)
        return "<br>".join([head, _line("length of r (m) over time"), traces("length", e.time, sizes)])
    stds = None if e.covariance is None else np.sqrt(np.maximum(np.diag(e.covariance), 0.0)).reshape(-1, 3)
    rows = []
    for i, value in enumerate(e.value):
        spread = [""] * 3 if stds is None else [f" ± {std:.2g}" for std in stds[i]]
        rows.append([f"imu{i + 1}", *(f"{x:.4f}{s}" for x, s in zip(value, spread, strict=True))])
    pairing = f"sign pairing {e.pairing}" if e.pairing else ""
    return "<br>".join(filter(None, [head, _table(["", "x", "y", "z"], rows), _line(pairing) if pairing else ""]))


def _score(s: Score) -> str:
    shown = {name: told(value, s.units[name]) for name, value in s.figures.items()}
    texts = [f"{value:.3g} {unit}" for value, unit in shown.values()]
    head = _line(f"Score of {s.estimator}: how far its {s.quantity} is off")
    return f"{head}<br>{bars('figures', {n: abs(v) for n, (v, _) in shown.items()}, texts)}"


def _diagnosis(d: Diagnosis) -> str:
    alarm = ": alarm" if d.alarm else ""
    parts = [_line(f"Diagnosis of {d.recording}: {d.verdict}{alarm}")]
    if d.findings:
        rows = [[f.effect, f.at, f"{100 * f.confidence:.0f} %", _moves(f.moves)] for f in d.findings[:ROWS]]
        parts.append(_table(["effect", "at", "sure", "moves"], rows))
        if len(d.findings) > ROWS:
            parts.append(_line(f"and {len(d.findings) - ROWS} more"))
    misfit = dict(zip(("as declared", "with what was found"), d.misfit, strict=True))
    parts.append(_line("misfit of the fitted motion, 1 is only noise"))
    parts.append(bars("misfit", misfit, [f"{value:.3g}" for value in misfit.values()]))
    return "<br>".join(parts)


def _moves(moves: Any) -> str:
    listed = (f"{k.replace('_', ' ')} {np.max(m.value):.2g} {m.unit}" for k, m in moves.items())
    return ", ".join(listed)


def _line(text: str) -> str:
    return f"<span>{escape(text)}</span>"


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    cells = "".join(f"<th>{escape(name)}</th>" for name in head)
    body = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table><tr>{cells}</tr>{body}</table>"


PAGES: dict[type, Callable[[Any], str]] = {
    Recording: _recording,
    Truth: _truth,
    Estimate: _estimate,
    Score: _score,
    Diagnosis: _diagnosis,
}
"""The content of each type's page."""
