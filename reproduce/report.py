"""A reproduction as one HTML file that needs nothing else: verdict first, then figures, then every claim."""

import base64
import io
from collections import Counter
from collections.abc import Sequence
from html import escape as escape_html
from importlib.resources import files

from imubench.errors import InputError
from imubench.reproduce.claims import Judged
from imubench.reproduce.paper import Figure, Paper, Story, Table

DPI = 130
WORDS = {
    "fails": "A promise of the paper that did not hold in this run.",
    "differs": "A number the authors saw that came out otherwise here; the last column says why.",
    "holds": "Within its bound.",
}


def page(paper: Paper, story: Story, judged: Sequence[Judged], how: str, footer: str) -> str:
    """Return the report; `how` is one sentence about the run, `footer` how to repeat it.

    Raises `InputError` where matplotlib is not installed.
    """
    style = (files("imubench.reproduce") / "report.css").read_text(encoding="utf-8")
    parts = [
        f"<!doctype html><html lang='en'><head><meta charset='utf-8'><title>{escape(paper.name)} reproduced</title>",
        "<meta name='viewport' content='width=device-width, initial-scale=1'>",
        f"<style>{style}</style></head><body>",
        f"<h1>{escape(headline(judged) if judged else story.exhibits[0].finding)}</h1>",
        f"<p class='soft'>{escape(paper.citation)}. {escape(how)}</p>",
        _verdict(judged) if judged else "",
        f"<h2>What was done</h2><p>{escape(story.setting)}</p>",
        "<h2>Figures and tables</h2>",
        *(_exhibit(e) for e in story.exhibits),
        "<h2 id='claims'>Every claim</h2>" + _claims(judged) if judged else "",
        "<h2>Readings taken and limits</h2><ul>",
        *(f"<li>{escape(note)}</li>" for note in story.notes),
        f"</ul><footer>{escape(footer)}</footer></body></html>\n",
    ]
    return "\n".join(parts)


def escape(text: str) -> str:
    """Return text for HTML, in attributes too, with the signs that a keyboard lacks."""
    for typed, printed in (("<=", "≤"), (">=", "≥"), ("+-", "±"), ("m/s^2", "m/s²")):
        text = text.replace(typed, printed)
    return escape_html(text, quote=True)


def headline(judged: Sequence[Judged]) -> str:
    """Return the outcome in one line."""
    counts = Counter(j.verdict for j in judged)
    text = f"{counts['holds']} of {len(judged)} claims hold"
    if counts["fails"]:
        text += f", {counts['fails']} {'fails' if counts['fails'] == 1 else 'fail'}"
    if counts["differs"]:
        text += f", {counts['differs']} {'figure differs' if counts['differs'] == 1 else 'figures differ'}"
    return text


def _verdict(judged: Sequence[Judged]) -> str:
    failed = [j for j in judged if j.verdict == "fails" or j.worse]
    if not failed:
        return "<div class='verdict good'><p>No promise of the paper failed.</p></div>"
    items = "".join(
        f"<p><b class='fails'>{'fails' if j.verdict == 'fails' else 'worse than before'}</b> {escape(j.claim.claim)}: "
        f"{escape(j.news) or f'{_number(j.measured.value)} {escape(j.claim.unit)} instead of {escape(j.claim.bound)}'}."
        f"</p><details class='soft'><summary>why</summary>{escape(j.measured.why)}.</details>"
        for j in failed
    )
    return f"<div class='verdict bad'>{items}</div>"


def _exhibit(exhibit: Figure | Table) -> str:
    label, finding = escape(exhibit.label), escape(exhibit.finding)
    title = f"<h3 id='{escape(exhibit.name)}'><span class='label'>{label}</span>{finding}</h3>"
    text = f"<p class='soft'>{escape(exhibit.text)}</p>"
    if isinstance(exhibit, Figure):
        return f"{title}<img alt='{label}: {finding}' src='{png(exhibit)}'>{text}"
    head = "".join(f"<th class='number'>{escape(c)}</th>" for c in exhibit.columns)
    rows = "".join(
        "<tr>" + "".join(f"<td class='number'>{escape(v)}</td>" for v in row) + "</tr>" for row in exhibit.rows
    )
    return f"{title}<div class='scroll'><table><tr>{head}</tr>{rows}</table></div>{text}"


def png(figure: Figure) -> str:
    """Return a figure as a data address; `InputError` where matplotlib is not installed."""
    require_matplotlib()
    buffer = io.BytesIO()
    figure.draw().savefig(buffer, dpi=DPI, format="png", metadata={"Software": None})
    return "data:image/png;base64," + base64.b64encode(buffer.getvalue()).decode("ascii")


def require_matplotlib() -> None:
    """Raise `InputError` where matplotlib is not installed, saying what to install."""
    try:
        import matplotlib  # noqa: F401
    except ImportError:
        raise InputError("figures: expected matplotlib, got none; pip install 'imubench[plot]'") from None


def _claims(judged: Sequence[Judged]) -> str:
    words = "".join(f"<li><b class='{v}'>{v}</b>: {escape(text)}</li>" for v, text in WORDS.items())
    columns = ("verdict", "claim", "paper", "here", "bound", "why")
    head = "".join(f"<th>{c}</th>" for c in columns)
    order = {verdict: k for k, verdict in enumerate(WORDS)}
    rows = "".join(_row(j) for j in sorted(judged, key=lambda j: order[j.verdict]))
    return f"<ul>{words}</ul><div class='scroll'><table class='claims'><tr>{head}</tr>{rows}</table></div>"


def _row(j: Judged) -> str:
    c = j.claim
    return (
        f"<tr><td class='verdict-cell {j.verdict}'>{j.verdict}</td>"
        f"<td>{escape(c.claim)}<br><span class='soft'>{escape(c.source)}</span></td>"
        f"<td class='number'>{c.published:g} {escape(c.unit)}</td>"
        f"<td class='number'>{_number(j.measured.value)} {escape(c.unit)}</td>"
        f"<td class='number' title='{escape(c.basis)}'>{escape(c.bound)}</td>"
        f"<td>{escape(j.measured.why)}</td></tr>"
    )


def _number(value: float) -> str:
    return f"{value:.3g}" if abs(value) < float("inf") else "none"
