"""A sweep as one HTML file that needs nothing else: what it shows first, the maps, then every number."""

from collections import Counter
from collections.abc import Sequence
from importlib.resources import files

import numpy as np

from imubench.figures import words
from imubench.reproduce.report import escape
from imubench.sweeps.cells import Cell, Map
from imubench.sweeps.drawing import figures, svg
from imubench.sweeps.finding import finding, headline
from imubench.sweeps.intervals import CONFIDENCE
from imubench.sweeps.spec import SWEEP_FILE, Sweep
from imubench.sweeps.work import ANSWERED, UNPLAYED, Outcome

WHYS = 3  # reasons that are told of each kind of failure


def page(
    sweep: Sweep, figure: str, found: Sequence[Cell], drawn: Sequence[Map], outcomes: Sequence[Outcome], footer: str
) -> str:
    """Return the page; `footer` says how to repeat the sweep."""
    style = "".join(
        (files(package) / "report.css").read_text(encoding="utf-8")
        for package in ("imubench.reproduce", "imubench.sweeps")
    )
    parts = [
        f"<!doctype html><html lang='en'><head><meta charset='utf-8'><title>{escape(sweep.name)}: a sweep</title>",
        "<meta name='viewport' content='width=device-width, initial-scale=1'>",
        f"<style>{style}</style></head><body>",
        f"<h1>{escape(headline(sweep, list(drawn)))}</h1>",
        f"<p class='soft'>{escape(sweep.summary)}</p>" if sweep.summary else "",
        f"<p>{escape(_setting(sweep, figure))}</p>",
        _figures(sweep, drawn),
        _key(sweep, drawn),
        _notes(sweep, drawn, outcomes),
        "<h2>Every number</h2>",
        *(_numbers(sweep, [c for c in found if c.estimator == m.estimator]) for m in drawn),
        f"<details><summary>The spec</summary><pre>{escape_spec(sweep)}</pre></details>",
        f"<footer>{escape(footer)}</footer></body></html>",
    ]
    return "\n".join(part for part in parts if part) + "\n"


def escape_spec(sweep: Sweep) -> str:
    """Return the spec's text as it stands, for HTML."""
    text = sweep.content[SWEEP_FILE].decode()
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")


def _setting(sweep: Sweep, figure: str) -> str:
    grid = " x ".join(str(len(axis.values)) for axis in sweep.axes)
    what = "median" if sweep.quantile == 0.5 else f"{100 * sweep.quantile:g} % quantile"
    return (
        f"Shown is the {what} over {sweep.recordings} recordings in each of {grid} cells of: {words(figure)}. "
        "The recordings with one number share rig, motion and noise over the whole grid; only what stands on the axes "
        "differs. A recording on which an estimator gives no answer counts as an infinite error."
    )


def _figures(sweep: Sweep, drawn: Sequence[Map]) -> str:
    pictures = figures(sweep, drawn)
    if len(sweep.axes) == 1:
        said = "<br>".join(escape(finding(sweep, m)) for m in drawn if len(drawn) > 1)
        caption = f"<figcaption>{said}</figcaption>" if said else ""
        alone = f"{caption}{svg(pictures[0], 'curves')}"
        return f"<div class='maps one'><figure>{alone}</figure></div>"
    if len(drawn) == 1:  # the headline has said it
        return f"<div class='maps'><figure>{svg(pictures[0], drawn[0].estimator)}</figure></div>"
    each = (
        f"<figure><figcaption>{escape(finding(sweep, m))}</figcaption>{svg(picture, m.estimator)}</figure>"
        for m, picture in zip(drawn, pictures, strict=True)
    )
    return f"<div class='maps'>{''.join(each)}</div>"


def _key(sweep: Sweep, drawn: Sequence[Map]) -> str:
    """Return what the signs of the pictures mean, those alone that are in one."""
    limit, percent = f"{sweep.limit:g} {sweep.unit}", f"{100 * CONFIDENCE:g} %"
    silent = any(np.isposinf(m.value).any() for m in drawn)
    part = bool((drawn[0].played < 1).any())
    known = any((np.isfinite(m.low) & (m.low > 0)).any() or np.isfinite(m.high).any() for m in drawn)
    few = f"No {percent} interval: {sweep.recordings} recordings in a cell are too few for one."
    if len(sweep.axes) == 1:
        shaded = (
            f"Shaded: {percent} interval, value by value, from order statistics; none where the recordings are too few "
            "for one."
        )
        lines = [f"Dashed: {limit}. {shaded if known else few}"]
        if silent:
            lines.append("Triangle on top: no answer in half of the recordings or more.")
        if part:
            lines.append("Cross below: some recordings cannot be played there; the curve is of those that can.")
        return f"<p class='soft'>{escape(' '.join(lines))}</p>"
    ends = not any(axis.is_text for axis in sweep.axes)
    some = any(((m.failed > 0) & np.isfinite(m.value)).any() for m in drawn)
    gone = bool((drawn[0].played == 0).any())
    rows = [
        ("below", f"below {limit}", True),
        ("above", f"above {limit}", True),
        ("limit", f"where the error passes {limit}", ends),
        ("ends", f"where the ends of its {percent} interval do, cell by cell, from order statistics", ends and known),
        ("some", "some recordings without an answer: the larger, the more", some),
        ("silent", "no answer in half of the recordings or more", silent),
        ("part", "some of the recordings cannot be played: the colour is of the others", part),
        ("gone", "none of the recordings can be played", gone),
    ]
    crossed = dict.fromkeys(("gone", "part"), "×")
    items = "".join(
        f"<li><span class='swatch {kind}'>{crossed.get(kind, '')}</span><span>{escape(text)}</span></li>"
        for kind, text, there in rows
        if there
    )
    more = "" if known or not ends else f"<p class='soft'>{escape(few)}</p>"
    return f"<ul class='key soft'>{items}</ul>{more}"


def _notes(sweep: Sweep, drawn: Sequence[Map], outcomes: Sequence[Outcome]) -> str:
    first = drawn[0].estimator
    gone = [o for o in outcomes if o.outcome == UNPLAYED and o.estimator == first]
    items = []
    if gone:
        cells, of = len({o.cell for o in gone}), sum(o.estimator == first for o in outcomes)
        items.append(
            f"{len(gone)} of {of} recordings, in {cells} of {drawn[0].value.size} cells, cannot be played. "
            f"In the sentences above they count as errors without bound. The first: {gone[0].why}"
        )
    for m in drawn:
        own = [o for o in outcomes if o.estimator == m.estimator and o.outcome not in (*ANSWERED, UNPLAYED)]
        for kind, count in Counter(o.outcome for o in own).most_common():
            whys = list(dict.fromkeys(o.why for o in own if o.outcome == kind))[:WHYS]
            items.append(f"{m.estimator}: {kind} on {count} recordings: {'; '.join(whys)}")
        unsure = sum(o.estimator == m.estimator and o.outcome in ANSWERED[1:] for o in outcomes)
        if unsure:
            answers = sum(o.estimator == m.estimator and o.outcome in ANSWERED for o in outcomes)
            items.append(
                f"{m.estimator} calls {unsure} of its {answers} answers not converged, or not identifiable; they count "
                "as they are"
            )
        if m.best_pairing:
            items.append(
                f"{m.estimator} does not always know how the signs of the two axes go together: where it says so, it "
                "is judged by the better of both ways"
            )
    return "<ul>" + "".join(f"<li>{escape(item)}.</li>" for item in items) + "</ul>" if items else ""


def _numbers(sweep: Sweep, own: Sequence[Cell]) -> str:
    """Return the table of an estimator: a column for each value of the second axis."""
    by_cell = {c.at: c for c in own}
    columns = [sweep.axes[0].label, *_heads(sweep)]
    rows = []
    for i, value in enumerate(sweep.axes[0].values):
        cells = "".join(_number(sweep, by_cell[(i, j)]) for j in range(sweep.shape[1]))
        rows.append(f"<tr><td class='number'>{escape(sweep.axes[0].shown(value))}</td>{cells}</tr>")
    head = "".join(f"<th class='number'>{escape(c)}</th>" for c in columns)
    body = f"<div class='scroll'><table><tr>{head}</tr>{''.join(rows)}</table></div>"
    what = f"{own[0].estimator}: error in {sweep.unit} (interval), share without an answer"
    return f"<details><summary>{escape(what)}</summary>{body}</details>"


def _heads(sweep: Sweep) -> list[str]:
    if len(sweep.axes) == 1:
        return [f"error, {sweep.unit}"]
    axis = sweep.axes[1]
    return [f"{axis.label} {axis.shown(value)}" if k == 0 else axis.shown(value) for k, value in enumerate(axis.values)]


def _number(sweep: Sweep, c: Cell) -> str:
    if not c.played:
        return "<td class='number'>×</td>"
    low, high = (_short(x) for x in c.interval)
    text = f"{_short(c.value)} ({low} to {high})"
    if c.failed:
        text += f", {100 * c.failed / c.played:.0f} %"
    if c.played < c.recordings:
        text += f", {c.recordings - c.played} ×"
    return f"<td class='number {'within' if c.bound <= sweep.limit else 'over'}'>{escape(text)}</td>"


def _short(value: float) -> str:
    return f"{value:.2g}" if value < 100 else "∞" if value == float("inf") else f"{value:.0f}"
