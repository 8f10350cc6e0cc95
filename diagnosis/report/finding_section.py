"""One finding: what it is, what it moves, its figure, its numbers, and, folded away, the evidence."""

from collections.abc import Iterable, Sequence

from imubench.diagnosis.evidence import Comparison, Evidence
from imubench.diagnosis.report import compared, words
from imubench.diagnosis.report.first_screen import ordered
from imubench.diagnosis.report.html import fold, table, term
from imubench.diagnosis.report.numbers import decimals, fixed, rows, size
from imubench.diagnosis.result import Diagnosis, Finding
from imubench.effects import EFFECTS
from imubench.reproduce.report import escape

PARAMETER_COLUMNS = ("parameter", "value", "95 % interval", "unit")


def findings(d: Diagnosis, evidence: Evidence) -> Iterable[str]:
    """Yield the sections of the findings, those that matter first by their share, the immaterial ones folded away."""
    if not d.findings:
        return
    named = any(f.named for f in d.findings)
    large, small = ordered(d, True), ordered(d, False)
    yield f"<h2>{'What the simulation leaves out' if named else 'What is left'}</h2>"
    if not large:
        yield f"<p>Nothing that moves anything by {escape(words.tolerance(d))}.</p>"
    for number, i in enumerate(large, 1):
        yield section(d, evidence, i, number)
    if small:
        body = "".join(section(d, evidence, i, number) for number, i in enumerate(small, len(large) + 1))
        yield f"<h2>Immaterial: below {escape(words.tolerance(d))}</h2>"
        yield "<ul>" + "".join(f"<li>{escape(_brief(d.findings[i]))}</li>" for i in small) + "</ul>"
        yield fold("Their figures and numbers", body)


def _brief(f: Finding) -> str:
    name = words.sentence(words.called(f.effect, f.at))
    moves = f": it moves {words.moved(f.moves)}" if f.moves else ""
    return f"{name} ({words.percent(f.confidence)} sure){moves}."


def section(d: Diagnosis, evidence: Evidence, i: int, number: int) -> str:
    """Return one finding; `i` is its place in the diagnosis, `number` what the page calls it."""
    f = d.findings[i]
    some: Sequence[Comparison] = evidence.comparisons[i] if i < len(evidence.comparisons) else ()
    sure = f"{words.certainty(f.confidence)}, {words.percent(f.confidence)}"
    share = "" if f.share is None else f"; without it {words.part(f.share)} of the difference comes back"
    parts = [
        f"<section class='finding'><h3><span class='label'>{number}</span>{escape(words.title(f))} "
        f"<span class='sure'>{sure}{share}</span></h3>"
    ]
    if f.where is not None and f.where not in d.where:
        parts.append(f"<p>{escape(words.location(f.where, evidence.span))}</p>")
    if f.moves:
        parts.append(f"<p>It moves: {escape(words.moved(f.moves))}.</p>")
    elif not some:
        parts.append("<p>What it moves is not known.</p>")
    parts.append(compared.figures(f, some, evidence.span[0], d.simulation) or compared.left_over(evidence, f))
    parts += [_numbers(f), _unseen(f), fold("The evidence for it", _evidence(f))]
    return "".join(parts) + "</section>"


def _numbers(f: Finding) -> str:
    """Return the parameters: joint statements of vectors, and a table of what the recording fixes."""
    if not f.parameters:
        return ""
    said = "".join(f"<p>{escape(text)}</p>" for name, p in f.parameters.items() if (text := size(name, p)))
    body = [row for name, p in f.parameters.items() for row in rows(name, p)]
    said += "".join(f"<p>{escape(text)}</p>" for text in [words.whose_axes(f)] if text)
    law = f"<p class='soft small'>Its law: {escape(EFFECTS[f.effect].law)}</p>" if f.effect in EFFECTS else ""
    return said + table(PARAMETER_COLUMNS, body) + law


def _unseen(f: Finding) -> str:
    if not f.unseen:
        return ""
    what = words.listed([f"the {text}" for text in f.unseen])
    return f"<p>This recording {term('unseen', 'does not show')} {escape(what)}.</p>"


def _evidence(f: Finding) -> str:
    gain, (low, high) = f.heldout_gain.value, f.heldout_gain.ci
    parts = []
    if f.named and gain == low == high == 0:
        parts.append("<p>The samples themselves show it, before any fit.</p>")
    elif f.named:
        digits = decimals(max(high - low, 1.0)) if abs(gain) < 100 else 0
        parts.append(
            f"<p>On {term('held out', 'samples that the fit has not seen')} the log-likelihood grows by "
            f"{fixed(gain, digits)} {term('nat')} ({fixed(low, digits)} to {fixed(high, digits)}).</p>"
        )
    for e in f.equivalent:
        beside = fixed(e.heldout_gain - gain, 0)
        parts.append(f"<p>{escape(words.sentence(words.called(e.effect, e.at)))} instead: {beside} nat beside it.</p>")
    if f.separate_by:
        parts.append(f"<p>To tell them apart: {escape(f.separate_by)}.</p>")
    return "".join(parts)


__all__ = ["findings", "section"]
