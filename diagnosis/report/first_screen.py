"""The first screen: what differs, where, because of what, how sure, what it does to an axis, and what to do next."""

import shlex
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from imubench.diagnosis.config.report import PAGE
from imubench.diagnosis.config.shared import CONFIDENCE
from imubench.diagnosis.config.simulation import SIMULATED_BESIDE
from imubench.diagnosis.evidence import Comparison, Evidence
from imubench.diagnosis.report import headline, words
from imubench.diagnosis.report.compared import changed_power, is_seen, title
from imubench.diagnosis.report.html import term
from imubench.diagnosis.report.moves_table import moves_table
from imubench.diagnosis.report.numbers import fixed
from imubench.diagnosis.result import Diagnosis, Finding
from imubench.estimators import ESTIMATORS
from imubench.models.tree import BALL, HINGE
from imubench.reproduce.report import escape

OFFERED = {HINGE: "olsson2020", BALL: "sliding"}
"""Which estimator a reader is offered for a joint where none was asked: a hinge's axis, the centre of a ball joint."""


@dataclass(frozen=True)
class Paths:
    """Where things are, as the reader would type them."""

    recording: str = "RECORDING"
    folder: str = "DIR"


def first_screen(d: Diagnosis, evidence: Evidence, paths: Paths) -> str:
    """Return the questions that a reader comes with, and their answers, as HTML."""
    rows = [("What differs?", what(d, evidence)), ("Where?", where(d, evidence))]
    if not d.fitted:
        wrong = "".join(f"<p>{escape(n.what)}.</p>" for n in d.nonsense)
        rows = [("What is wrong?", wrong)]
    elif d.findings:
        rows += [
            ("Because of what?", because(d)),
            ("How sure?", how_sure(d)),
            ("What does it do to my results?", does(d, evidence)),
        ]
    rows += [("What next?", next_steps(d, evidence)), ("Commands to copy", commands(d, evidence, paths))]
    items = "".join(f"<dt>{question}</dt><dd>{answer}</dd>" for question, answer in rows if answer)
    return f"<dl class='answers'>{items}</dl>"


def ordered(d: Diagnosis, material: bool) -> list[int]:
    """Return the places of the material findings, or of the others, largest share first."""
    some = [i for i, f in enumerate(d.findings) if f.material is material]
    return sorted(some, key=lambda i: -(d.findings[i].share or 0.0))


def what(d: Diagnosis, evidence: Evidence) -> str:
    """Return how far the simulations are off."""
    parts = []
    if d.simulation is not None and d.simulation.channels:
        how = term(d.simulation.how)
        if d.simulation.how == "rolled out":
            begins = words.listed([f"{a - evidence.span[0]:.1f}" for a, _ in d.simulation.windows_s])
            how = f"{term('rolled out', 'rolled out by forces alone')} from the states at {begins} s"
        judged = (
            f"Judged on {term('held out', 'samples that the numbers were not learned from')}."
            if d.simulation.heldout
            else "The numbers were learned on the same samples."
        )
        change = "RMS, as declared → with what was found" if sure(d) else "RMS"
        parts.append(
            f"<p>MuJoCo's simulation, {how}, is off by ({change}):</p>{_bars(d)}<p class='soft small'>{judged}</p>"
        )
        if (changes := without_each(d, evidence)) and not headline.shown_by(d.simulation):
            parts.append(
                "<p>A motion was recovered with which the declared model follows the sensors as well. Held to "
            )
            parts.append("the motion that was recovered with everything found:</p>")
            parts += [f"<p>{escape(text)}.</p>" for text in changes]
    elif d.fitted:
        before, after = (fixed(x, 2) for x in d.misfit)
        change = before if before == after else f"{before} as declared, {after} with what was found"
        parts.append(f"<p>What the fitted motion leaves, {term('misfit')}: {change} (1: only noise).</p>")
    share = headline.explained_percent(d)
    if share and sure(d):
        parts.append(f"<p>What was found explains <b>{share}</b> of the power of what differs.</p>")
    usual = headline.usual_noise(d, {i.name: i.rate for i in evidence.recording.imus})
    if usual:
        parts.append(f"<p class='soft small'>The noise is not known: {escape(usual)}</p>")
    return "".join(parts)


def sure(d: Diagnosis) -> bool:
    """Return whether an effect of the library was found for sure."""
    return any(f.named and f.confidence >= CONFIDENCE.counts for f in d.findings)


def without_each(d: Diagnosis, evidence: Evidence) -> list[str]:
    """Return for each finding that is compared how far the simulation is off without it and with it."""
    pairs = zip(d.findings, evidence.comparisons, strict=False)
    return [
        title(max(some, key=changed_power), words.called(f.effect, f.at))
        for f, some in pairs
        if any(map(is_seen, some))
    ]


def _bars(d: Diagnosis) -> str:
    """Return the channels that differ most, as declared and with what was found, in figures."""
    assert d.simulation is not None
    rows = []
    for off in headline.deviations(d.simulation)[: SIMULATED_BESIDE.channels]:
        change = f"<b>{off.before}</b>" if off.before == off.after else f"<b>{off.before}</b> → <b>{off.after}</b>"
        times = f"{_times(off.times_before)} → {_times(off.times_after)} times the noise"
        if not sure(d):
            change, times = f"<b>{off.before}</b>", f"{_times(off.times_before)} times the noise"
        known = not any(name.startswith(off.channel.partition(".")[0]) for name in d.noise_unknown)
        note = f"noise {off.noise}, {times}" if known else "its noise is not known"
        rows.append(
            f"<li>{escape(words.spelled(off.channel))}: {change} {escape(off.unit)} "
            f"<span class='soft small'>({escape(note)})</span></li>"
        )
    return f"<ul class='plain'>{''.join(rows)}</ul>"


def _times(value: float) -> str:
    return f"{value:.1f}" if value < 10 else f"{value:,.0f}".replace(",", " ")


def where(d: Diagnosis, evidence: Evidence) -> str:
    """Return where the recording differs from the declared model."""
    texts = headline.places(d, evidence.span)
    return "".join(f"<p>{escape(words.sentence(text))}</p>" for text in texts[: PAGE.listed])


def because(d: Diagnosis) -> str:
    """Return what the simulation leaves out, those that matter first."""
    shown_first = [d.findings[i] for i in ordered(d, True)]
    items = "".join(f"<li>{escape(words.called(f.effect, f.at))}{_share(f)}</li>" for f in shown_first)
    small = [d.findings[i] for i in ordered(d, False)]
    rest = ""
    if small:
        names = words.listed([words.called(f.effect, f.at) for f in small])
        rest = f"<p class='soft'>{term('immaterial', 'Immaterial')}: {escape(names)}.</p>"
    return (f"<ol class='plain'>{items}</ol>" if items else "") + rest


def _share(f: Finding) -> str:
    if f.share is None:
        return ""
    return f": without it {words.part(f.share)} of the difference {term('share', 'comes back')}"


def how_sure(d: Diagnosis) -> str:
    """Return how sure the findings are, and what they could be instead."""
    parts = []
    for i in [*ordered(d, True), *ordered(d, False)]:
        f = d.findings[i]
        instead = ""
        if f.equivalent:
            others = words.listed([words.called(e.effect, e.at) for e in f.equivalent])
            instead = f" This recording cannot tell it from {others}."
        name = words.sentence(words.called(f.effect, f.at))
        parts.append(
            f"<p>{escape(f'{name}: {words.certainty(f.confidence)}, {words.percent(f.confidence)}.{instead}')}</p>"
        )
    parts += [f"<p><b>Not to be trusted:</b> {escape(doubt.of)}: {escape(doubt.why)}.</p>" for doubt in d.doubts]
    return "".join(parts)


def does(d: Diagnosis, evidence: Evidence) -> str:
    """Return what the findings move of what a reader asks for."""
    limit = f"{d.tolerance[0]:g} deg or {d.tolerance[1]:g} mm"
    parts = [
        f"<p><b>{term('alarm', 'Alarm')}</b>: what is likely there may move your results by {limit}, or more.</p>"
        if d.alarm
        else f"<p>No {term('alarm')}: {escape(words.alarm(d))}</p>"
    ]
    numbered = ordered(d, True)
    parts.append(moves_table(d, evidence, numbered))
    for i in (i for i in numbered if not d.findings[i].moves):
        compared = evidence.comparisons[i] if i < len(evidence.comparisons) else ()
        parts.append(f"<p>{escape(consequence(d.findings[i], compared))}</p>")
    for name, was, now in headline.against_reference(d):
        parts.append(
            f"<p>Against the {term('reference')}, the {escape(name)} is off by "
            f"{fixed(was, 2)} → {fixed(now, 2)} deg RMS.</p>"
        )
    return "".join(parts)


def consequence(f: Finding, compared: Sequence[Comparison]) -> str:
    """Return what a finding moves, or what its simulated channel does without it, in a sentence."""
    name = words.called(f.effect, f.at)
    if f.moves:
        return f"{words.sentence(name)} moves {words.moved(f.moves)}."
    if compared and is_seen(max(compared, key=changed_power)):
        return f"{title(max(compared, key=changed_power), name)}."
    return f"What {name} moves is not known."


def next_steps(d: Diagnosis, evidence: Evidence) -> str:
    """Return what to do now."""
    return "".join(f"<p>{escape(text)}</p>" for text in steps(d, evidence))


def steps(d: Diagnosis, evidence: Evidence) -> Iterator[str]:
    """Yield what to do now, in sentences."""
    if not d.fitted:
        yield from headline.places(d, evidence.span)  # what to look at
        return
    if d.stopped:
        yield words.stopped(d)
        yield "Diagnose it again with a longer --time-limit, or a shorter part of it, in which it moves briskly."
    for u in d.unseen:
        yield f"To see {u.what}: {u.motion}."
    for f in d.findings:
        if f.separate_by:
            yield f"To tell {words.called(f.effect, f.at)} from what could stand for it, record {words.motion(f)}."
    if correctable(d, evidence):
        yield "Take what was found out of the recording and estimate again: the first command below."
    elif d.doubts:
        yield "Do not correct with it: the numbers are not to be trusted."
    if not d.findings and not d.unseen:
        yield "Nothing needs to be done."


def correctable(d: Diagnosis, evidence: Evidence) -> bool:
    """Return whether `estimate --with` can take out what was found."""
    kind = evidence.recording.tree.kind
    if kind not in OFFERED or not sure(d) or d.doubts:
        return False
    return len(evidence.recording.imus) >= ESTIMATORS[offered(evidence)].imus


def offered(evidence: Evidence) -> str:
    """Return the estimator that a reader is offered: that whose answers the page shows, so that both agree."""
    return evidence.estimates[0].estimator if evidence.estimates else OFFERED[evidence.recording.tree.kind]


def commands(d: Diagnosis, evidence: Evidence, paths: Paths) -> str:
    """Return the commands that a reader may copy."""
    return "".join(f"<pre><code>{escape(line)}</code></pre>" for line in command_lines(d, evidence, paths))


def command_lines(d: Diagnosis, evidence: Evidence, paths: Paths) -> list[str]:
    """Return what to type to correct an estimate, to play the model, and to look at all of it."""
    recording, folder = (shlex.quote(p) for p in (paths.recording, paths.folder))
    lines = []
    if correctable(d, evidence):
        lines.append(f"imubench estimate {offered(evidence)} {recording} --with {folder}")
    if d.fitted and d.model:
        lines.append(f"imubench run {shlex.quote(f'{paths.folder}/model')}")
    return [*lines, f"rerun {shlex.quote(f'{paths.folder}/diagnosis.rrd')}"]


__all__ = ["Paths", "command_lines", "consequence", "correctable", "first_screen", "ordered", "steps"]
