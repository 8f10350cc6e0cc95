"""The page: an answer to each question on the first screen, then the findings, the map, and the evidence folded."""

from collections.abc import Iterable
from importlib.resources import files

import imubench
from imubench.diagnosis.config.report import PAGE
from imubench.diagnosis.evidence import Evidence
from imubench.diagnosis.report import headline, words
from imubench.diagnosis.report.finding_section import findings
from imubench.diagnosis.report.first_screen import Paths, first_screen
from imubench.diagnosis.report.html import fold, table, term
from imubench.diagnosis.report.misfit_map import misfit_map
from imubench.diagnosis.report.numbers import fixed, shown
from imubench.diagnosis.result import Diagnosis
from imubench.diagnosis.rules import RULES, Decision
from imubench.glossary import TERMS
from imubench.reproduce.report import escape

MAP_TEXT = (
    "Each row is a channel of a sensor. Pale: the model explains it down to the sensor's noise. "
    "The darker, the farther the recording is from the model."
)


def page(d: Diagnosis, evidence: Evidence, paths: Paths | None = None) -> str:
    """Return the report as one HTML file that needs nothing else.

    Args:
        d: what was found.
        evidence: what the figures are drawn from.
        paths: how the reader would type the recording and the folder of the results; None: placeholders.
    """
    style = "".join(
        (files(package) / "report.css").read_text(encoding="utf-8")
        for package in ("imubench.reproduce", "imubench.diagnosis.report")
    )
    parts = [
        f"<!doctype html><html lang='en'><head><meta charset='utf-8'><title>{escape(d.recording)} diagnosed</title>",
        "<meta name='viewport' content='width=device-width, initial-scale=1'>",
        "<meta name='color-scheme' content='light dark'>",
        f"<style>{style}</style></head><body>",
        f"<p class='soft over'>Diagnosis of {escape(d.recording)}: {escape(_what(evidence))}</p>",
        f"<h1 class='verdict {words.VERDICT_LOOKS[d.verdict]}'>{escape(headline.headline(d))}</h1>",
        f"<p>{escape(words.baseline(d.baseline))}</p>" if d.baseline is not None else "",
        first_screen(d, evidence, paths or Paths()),
        *(findings(d, evidence) if d.fitted else ()),
        *_map(d, evidence),
        _doubts(d),
        _unseen(d),
        "<h2>Evidence and method</h2>",
        fold("How well the fitted motion agrees with the sensors", _misfit(d)),
        fold("What was tried and not taken", _rejected(d)),
        fold("What the search decided, and by which rules", _search(evidence)),
        fold("Channels left out", _quality(d)),
        fold("Noise, and how it was done", _how(d, evidence)),
        fold("What the words mean", _glossary()),
        f"<footer>imubench {imubench.__version__}, {d.seconds:.1f} s. The same in numbers: diagnosis.json. "
        "A word, an effect or a figure in plain words: <code>imubench explain NAME</code>.</footer></body></html>\n",
    ]
    return "\n".join(part for part in parts if part)


def _what(evidence: Evidence) -> str:
    recording = evidence.recording
    seconds = evidence.span[1] - evidence.span[0]
    sensors = [f"{i.name} at {i.rate:g} Hz" for i in recording.imus]
    sensors += ["an encoder"] * len(recording.encoders) + ["a measured pose"] * len(recording.poses)
    return f"{recording.rig}, {seconds:.0f} s, {words.listed(sensors)}"


def _map(d: Diagnosis, evidence: Evidence) -> Iterable[str]:
    if not d.fitted:
        return
    whose = "MuJoCo's simulation" if evidence.simulated else "the fitted motion, which is free to follow the sensors,"
    yield "<h2>Where and when they differ</h2>"
    for text in headline.places(d, evidence.span)[PAGE.listed :]:
        yield f"<p>{escape(words.sentence(text))}</p>"
    yield f"<p class='soft'>Below: by how many times its noise each channel differs from {whose} "
    yield f"over time, in seconds from the recording's start, and over frequency. {escape(MAP_TEXT)}</p>"
    yield misfit_map(evidence, d.where, any(f.named for f in d.findings))


def _misfit(d: Diagnosis) -> str:
    if not d.fitted:
        return ""
    body = [
        ("on the samples it was fitted to", *(fixed(x, 2) for x in d.misfit)),
        ("each sample predicted from all others", *(fixed(x, 2) for x in d.fit.heldout)),
    ]
    text = (
        f"<p>{term('misfit', 'Misfit')} of a spline motion that is free to follow the sensors: "
        "residual power over noise power, 1 is only noise.</p>"
    )
    return text + table(("misfit", "as declared", "with what was found"), body)


def _rejected(d: Diagnosis) -> str:
    body = [
        (words.called(r.effect, r.at), fixed(r.heldout_gain, 0), words.rejection(r))
        for r in sorted(d.rejected, key=lambda r: -r.heldout_gain)
    ]
    return table(("effect", "gain (nat)", "why not"), body, last=2) if body else ""


def _search(evidence: Evidence) -> str:
    if not evidence.fired:
        return ""
    decided = [(x.what, x.rule, _last_test(x)) for x in evidence.decisions]
    fired = [(name, RULES[name], str(count)) for name, count in evidence.fired.items()]
    return (
        (table(("what was proposed", "by the rule", "its last test"), decided, last=1) if decided else "")
        + "<p>Rules that changed something:</p>"
        + table(("rule", "what it does", "times"), fired, last=1)
    )


def _last_test(decision: Decision) -> str:
    met = f": {decision.tests[-1].met}" if decision.tests else ""
    return f"{'taken' if decision.accepted else 'refused'}{met}"


def _doubts(d: Diagnosis) -> str:
    if not d.doubts:
        return ""
    items = "".join(f"<li><b>{escape(doubt.of)}</b>: {escape(doubt.why)}.</li>" for doubt in d.doubts)
    return f"<h2>Why the model is not to be trusted</h2><ul>{items}</ul>"


def _unseen(d: Diagnosis) -> str:
    if not d.unseen or not d.fitted:  # the headline says it
        return ""
    items = "".join(
        f"<li>{escape(words.sentence(u.what))}. <b>To see it:</b> {escape(u.motion)}.</li>" for u in d.unseen
    )
    return f"<h2>What this recording cannot show</h2><ul>{items}</ul>"


def _quality(d: Diagnosis) -> str:
    change = d.fit.left_out_channel
    if not change.before:
        return ""
    body = [(name, fixed(before, 2), fixed(change.after[name], 2)) for name, before in change.before.items()]
    text = (
        "<p>Each channel was hidden in turn and predicted from all others; the error is in units of its noise. "
        "Near 1 the sensors agree. It may grow where a finding frees a sensor from the others, as a soft mount does: "
        "then these say less of that sensor.</p>"
    )
    return text + table(("channel", "as declared", "with what was found"), body)


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
        f"<ul>{notes}</ul><p>Standard deviation of the {term('noise')} per sample. Where none is declared, that of the "
        f"quietest moments.</p>{table(columns, body, last=4)}"
    )


def _glossary() -> str:
    return (
        "<dl class='words'>" + "".join(f"<dt>{escape(n)}</dt><dd>{escape(t)}</dd>" for n, t in TERMS.items()) + "</dl>"
    )


__all__ = ["page"]
