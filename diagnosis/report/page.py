"""The page: the verdict, a map of the misfit, each finding, what was not taken, what could not be seen, how."""

import base64
import io
from collections.abc import Callable, Iterable, Sequence
from importlib.resources import files
from typing import TYPE_CHECKING

import imubench
from imubench.diagnosis.evidence import Comparison, Evidence
from imubench.diagnosis.report import figures, words
from imubench.diagnosis.report.numbers import decimals, fixed, rows, shown
from imubench.diagnosis.result import Diagnosis, Finding
from imubench.reproduce.report import DPI, escape, require_matplotlib

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

SHOWN_REJECTED = 8
MAP_TEXT = (
    "Each row is a channel of a sensor. Pale: the model explains it down to the sensor's noise. "
    "The darker, the farther the recording is from the model. Blue frames: where most of the difference sits."
)


def page(d: Diagnosis, evidence: Evidence) -> str:
    """Return the report as one HTML file that needs nothing else; `InputError` where matplotlib is not installed."""
    require_matplotlib()
    style = "".join(
        (files(package) / "report.css").read_text(encoding="utf-8")
        for package in ("imubench.reproduce", "imubench.diagnosis.report")
    )
    parts = [
        f"<!doctype html><html lang='en'><head><meta charset='utf-8'><title>{escape(d.recording)} diagnosed</title>",
        "<meta name='viewport' content='width=device-width, initial-scale=1'>",
        f"<style>{style}</style></head><body>",
        f"<p class='soft over'>Diagnosis of {escape(d.recording)}: {escape(_what(evidence))}</p>",
        f"<h1 class='verdict {words.VERDICTS[d.verdict]}'>{escape(words.headline(d))}</h1>",
        f"<p>{'<b>Alarm</b>' if d.alarm else 'No alarm'}: {escape(words.alarm(d))}</p>" if d.findings else "",
        f"<p>{escape(words.baseline(d.baseline))}</p>" if d.baseline is not None else "",
        f"<p class='todo'>{escape(words.stopped(d))}</p>" if d.stopped else "",
        _tiles(d) if d.fitted else "",
        f"<h2>{'Where they differ' if d.fitted else 'What is wrong'}</h2>",
        *(f"<p>{escape(text)}</p>" for text in words.places(d, evidence.span)),
        _image(lambda: figures.misfit_map(evidence, d.where), "Map of the misfit", MAP_TEXT) if d.fitted else "",
        *(_findings(d, evidence) if d.fitted else ()),
        _rejected(d),
        _doubts(d),
        _unseen(d),
        _quality(d),
        _how(d, evidence),
        f"<footer>imubench {imubench.__version__}, {d.seconds:.1f} s. The same in numbers: diagnosis.json; in 3D and "
        "over time: diagnosis.rrd, opened with <code>rerun diagnosis.rrd</code>.</footer></body></html>\n",
    ]
    return "\n".join(part for part in parts if part)


def _what(evidence: Evidence) -> str:
    recording = evidence.recording
    seconds = evidence.span[1] - evidence.span[0]
    sensors = [f"{i.name} at {i.rate:g} Hz" for i in recording.imus]
    sensors += ["an encoder"] * len(recording.encoders) + ["a measured pose"] * len(recording.poses)
    return f"{recording.rig}, {seconds:.0f} s, {words.listed(sensors)}"


def _tiles(d: Diagnosis) -> str:
    tiles = [("misfit (1: only sensor noise)", _step(*d.misfit, digits=2))]
    tiles.append(("the same on data the fit has not seen", _step(*d.fit.heldout, digits=2)))
    for name in d.fit.reference.before:
        before, unit = _laboratory(d.fit.reference.before[name], d.fit.reference.unit)
        after, _ = _laboratory(d.fit.reference.after[name], d.fit.reference.unit)
        label = f"{words.MEASURED.get(name, name)} against the reference ({unit})"
        tiles.append((label, _step(before, after, digits=2)))
    items = "".join(f"<div><b>{value}</b><span>{escape(label)}</span></div>" for label, value in tiles)
    return f"<div class='tiles'>{items}</div>"


def _step(before: float, after: float, digits: int) -> str:
    old, new = fixed(before, digits), fixed(after, digits)
    return new if old == new else f"<i>{old}</i> → {new}"


def _laboratory(value: float, unit: str) -> tuple[float, str]:
    base, _, rest = unit.partition(" ")
    number, name = shown(value, base)
    return number, f"{name} {rest}".strip()


def _findings(d: Diagnosis, evidence: Evidence) -> Iterable[str]:
    if not d.findings:
        return
    named = any(f.named for f in d.findings)
    yield f"<h2>{'What the simulation leaves out' if named else 'What is left'}</h2>"
    order = sorted(range(len(d.findings)), key=lambda i: not d.findings[i].material)
    small = sum(f.material for f in d.findings) + 1  # the number of the first that is not
    for number, i in enumerate(order, 1):
        finding = d.findings[i]
        if number == small:
            yield f"<h2>Immaterial: below {escape(words.tolerance(d))}</h2>"
        compared = evidence.comparisons[i] if i < len(evidence.comparisons) else ()
        place = ""
        if finding.where is not None and finding.where not in d.where:
            place = f"<p>{escape(words.location(finding.where, evidence.span))}</p>"
        yield _finding(finding, number, place, compared, evidence)


def _finding(f: Finding, number: int, place: str, compared: Sequence[Comparison], evidence: Evidence) -> str:
    sure = f"{words.certainty(f.confidence)}, {words.percent(f.confidence)}"
    parts = [
        f"<section class='finding'><h3><span class='label'>{number}</span>{escape(words.title(f))} "
        f"<span class='sure'>{sure}</span></h3>{place}<p>It moves: {escape(words.moved(f))}.</p>"
    ]
    for one in compared:
        alt = f"{one.channel} measured, and by the model without and with it"
        parts.append(_image(lambda one=one: figures.before_after(one), alt))  # type: ignore[misc]
    if not compared:
        parts.append(_image(lambda: figures.left_over(evidence, f), "What is left of its loudest channel"))
    if f.parameters:
        body = [row for name, p in f.parameters.items() for row in rows(name, p)]
        parts.append(_table(("parameter", "value", "95 % interval", "unit"), body))
    gain, (low, high) = f.heldout_gain.value, f.heldout_gain.ci
    if f.named and gain == low == high == 0:
        parts.append("<p class='soft'>The samples themselves show it, before any fit.</p>")
    elif f.named:
        digits = decimals(max(high - low, 1.0)) if abs(gain) < 100 else 0
        parts.append(
            f"<p class='soft'>It makes data that the fit has not seen more likely by {fixed(gain, digits)} nat "
            f"({fixed(low, digits)} to {fixed(high, digits)}).</p>"
        )
    if f.equivalent:
        parts.append("<p>This recording cannot tell it from: " + "; ".join(_equivalent(f)) + ".</p>")
    if f.separate_by:
        parts.append(f"<p class='todo'>To find out, record {escape(f.separate_by)}</p>")
    return "".join(parts) + "</section>"


def _equivalent(f: Finding) -> Iterable[str]:
    for e in f.equivalent:
        gain = fixed(e.heldout_gain - f.heldout_gain.value, 0)
        yield f"<b>{escape(words.called(e.effect, e.at))}</b> ({gain} nat beside it)"


def _rejected(d: Diagnosis) -> str:
    if not d.rejected:
        return ""
    body = [
        (words.called(r.effect, r.at), fixed(r.heldout_gain, 0), words.rejection(r))
        for r in sorted(d.rejected, key=lambda r: -r.heldout_gain)
    ]
    columns = ("effect", "gain on unseen data (nat)", "why not")
    rest = ""
    if len(body) > SHOWN_REJECTED:
        count = len(body) - SHOWN_REJECTED
        rest = f"<details><summary>{count} more</summary>{_table(columns, body[SHOWN_REJECTED:], last=2)}</details>"
    return f"<h2>What was tried and not taken</h2>{_table(columns, body[:SHOWN_REJECTED], last=2)}{rest}"


def _doubts(d: Diagnosis) -> str:
    if not d.doubts:
        return ""
    items = "".join(f"<li><b>{escape(doubt.of)}</b>: {escape(doubt.why)}.</li>" for doubt in d.doubts)
    return f"<h2>Why the model is not to be trusted</h2><ul>{items}</ul>"


def _unseen(d: Diagnosis) -> str:
    if not d.unseen or not d.fitted:  # the headline says it
        return ""
    items = "".join(f"<li>{escape(u.what)}. <b>To see it:</b> {escape(u.motion)}.</li>" for u in d.unseen)
    return f"<h2>What this recording cannot show</h2><ul>{items}</ul>"


def _quality(d: Diagnosis) -> str:
    change = d.fit.left_out_channel
    if not change.before:
        return ""
    body = [(name, fixed(before, 2), fixed(change.after[name], 2)) for name, before in change.before.items()]
    text = "Each channel predicted by a fit that has not seen any of it; the error is given in units of its noise."
    return f"<h2>Channels left out</h2><p>{text}</p>{_table(('channel', 'as declared', 'with it'), body)}"


def _how(d: Diagnosis, evidence: Evidence) -> str:
    body = []
    for level in evidence.levels:
        source = d.noise[level.group].source if level.group in d.noise else ""
        factor, unit = shown(1.0, level.unit)
        levels = [None if x is None else x * factor for x in (level.declared, level.used, level.left)]
        body.append((level.group, *("none" if x is None else f"{x:.3g}" for x in levels), unit, source))
    columns = ("channels", "declared", "taken", "left by the declared model", "unit", "known from")
    notes = "".join(f"<li>{escape(note)}</li>" for note in evidence.notes)
    return (
        f"<h2>How it was done</h2><ul>{notes}</ul>"
        f"<p>Standard deviation of the noise per sample. Where none is declared, that of the quietest moments.</p>"
        f"{_table(columns, body, last=4)}"
    )


def _table(columns: Sequence[str], body: Iterable[Sequence[str]], last: int = 3) -> str:
    """Return a table; columns 1 to before `last` hold numbers."""
    kind = ["number" if 1 <= i < last else "" for i in range(len(columns))]
    head = "".join(f"<th class='{k}'>{escape(c)}</th>" for k, c in zip(kind, columns, strict=True))
    lines = "".join(
        "<tr>" + "".join(f"<td class='{k}'>{escape(v)}</td>" for k, v in zip(kind, row, strict=True)) + "</tr>"
        for row in body
    )
    return f"<div class='scroll'><table class='narrow'><tr>{head}</tr>{lines}</table></div>"


def _image(draw: "Callable[[], Drawing | None]", alt: str, text: str = "") -> str:
    import matplotlib

    with matplotlib.rc_context(figures.FONT):
        figure = draw()
        if figure is None:
            return ""
        buffer = io.BytesIO()
        figure.savefig(buffer, dpi=DPI, format="png", metadata={"Software": None})
    source = "data:image/png;base64," + base64.b64encode(buffer.getvalue()).decode("ascii")
    below = f"<p class='soft'>{escape(text)}</p>" if text else ""
    return f"<img alt='{escape(alt)}' src='{source}'>{below}"
