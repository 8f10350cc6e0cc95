"""The figure of a finding: measured, without it, with it, and what each gets wrong, where it matters most."""

from collections.abc import Sequence

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.report import PAGE
from imubench.diagnosis.config.shared import DECLARED_NOISE
from imubench.diagnosis.evidence import Comparison, Evidence, Trace
from imubench.diagnosis.report.chart import Line, Panel, chart
from imubench.diagnosis.report.numbers import brief, printed
from imubench.diagnosis.report.shares import power_explained
from imubench.diagnosis.report.words import called, spelled
from imubench.diagnosis.result import Finding, Simulation
from imubench.diagnosis.samples.spectra import spectrum

PLACES_OF_TORQUE = ("joint", "body", "world")
ABSORBED_SENTENCE = (
    "<p>Without it the simulation follows the sensors as well: another motion, or another seat of the sensor, takes "
    "its place. What that moves shows the difference.</p>"
)
KEYS = (("measured", "measured"), ("before", "simulated without it"), ("after", "simulated with it"))
NOISE_KEY = ("band", "sensor noise, 95 % of it")
HELD_KEY = ("held", "learned on other samples than these")


def figures(finding: Finding, compared: Sequence[Comparison], start: float, simulation: Simulation | None) -> str:
    """Return the figures of a finding as HTML; empty where nothing is compared.

    Args:
        finding: the finding.
        compared: its channels, measured and simulated without and with it.
        start: s, the recording's first time: figures count from there.
        simulation: of the diagnosis; of what was rolled out a torque's whole swing is shown.
    """
    rolled = simulation is not None and simulation.how == "rolled out"
    whole = rolled and finding.at in PLACES_OF_TORQUE
    best = [c for c in sorted(compared, key=changed_power, reverse=True)[: PAGE.listed] if is_seen(c)]
    name = called(finding.effect, finding.at)
    if compared and not best:
        return ABSORBED_SENTENCE
    return "".join(figure(one, name, start, whole) for one in best)


def figure(c: Comparison, name: str, start: float, whole: bool = False) -> str:
    """Return one channel as a figure: the signals above, what the models without and with `name` get wrong beneath."""
    factor, unit = printed(c.unit)
    time = c.time - start
    measured, before, after = (factor * y for y in (c.measured, c.before, c.after))
    some = slice(0, len(time)) if whole else loudest(time, after - before)
    span = (float(time[some][0]), float(time[some][-1]))
    held = [(max(a - start, span[0]), min(b - start, span[1])) for a, b in c.held_out]
    seen = [(a, b) for a, b in held if b > a]
    step = (span[1] - span[0]) / max(len(time[some]) - 1, 1)
    everywhere = sum(b - a for a, b in seen) >= (span[1] - span[0]) - 2 * step
    seen = [] if everywhere else seen
    signals = [
        Line(time, measured, "measured", dots=True),
        Line(time, before, "before"),
        Line(time, after, "after"),
    ]
    errors = [Line(time, before - measured, "before"), Line(time, after - measured, "after")]
    panels = [
        Panel(f"{spelled(c.channel)} ({unit})", signals, span, "s", marked=seen),
        Panel(f"simulated minus measured ({unit})", errors, span, "s", 2 * factor * c.noise, seen, tall=False),
    ]
    keys = [*KEYS, NOISE_KEY, *([HELD_KEY] if seen else [])]
    note = "All of it was simulated with numbers that were learned on other samples." if everywhere else ""
    return chart(title(c, name), panels, keys, " ".join(part for part in (_part_shown(span, time), note) if part))


def title(c: Comparison, name: str) -> str:
    """Return in a sentence how far the simulation of a channel is off without and with what is called `name`."""
    factor, unit = printed(c.unit)
    without, with_it = (brief(factor * float(np.sqrt(np.mean((y - c.measured) ** 2)))) for y in (c.before, c.after))
    return (
        f"Without {name} the simulated {spelled(c.channel)} is off by {without} {unit} RMS, with it by {with_it} "
        f"(noise {brief(factor * c.noise)})"
    )


def _part_shown(span: tuple[float, float], time: Array) -> str:
    if span[1] - span[0] > 0.99 * (time[-1] - time[0]):
        return ""
    return (
        f"Shown: {span[0]:.1f} to {span[1]:.1f} s from the recording's start, where it matters most; "
        f"the numbers above are over all {time[-1] - time[0]:.0f} s."
    )


def left_over(evidence: Evidence, finding: Finding) -> str:
    """Return the loudest channel of something unknown: its residual where it is loudest, and its spectrum."""
    if finding.where is None:
        return ""
    at, shares = finding.where.at, finding.where.channels
    channel = max(shares, key=lambda c: shares[c])
    if not any(t.at == at and channel in t.channels for t in evidence.traces):
        return ""  # a torque: no sensor reads it
    trace, column = evidence.trace(at, channel)
    return residual(trace, column, evidence.span[0], finding.where.bands_hz)


def residual(trace: Trace, column: int, start: float, bands_hz: Sequence[tuple[float, float]]) -> str:
    """Return what is left of one channel as a figure, over time and over frequency."""
    factor, unit = printed(trace.unit)
    values = factor * (trace.before if trace.after is None else trace.after)[:, column]
    time, noise = trace.time - start, factor * trace.noise
    some = loudest(time, values)
    span = (float(time[some][0]), float(time[some][-1]))
    f, density = spectrum(trace.time, values[:, None])
    white = np.full(len(f), noise * np.sqrt(2 * float(np.median(np.diff(trace.time)))))
    name = spelled(f"{trace.at}.{trace.channels[column]}")
    size = float(np.sqrt(np.mean(values**2)))
    panels = [
        Panel(f"measured minus fitted ({unit})", [Line(time, values, "left")], span, "s", 2 * noise, tall=False),
        Panel(
            f"over frequency ({unit} per √Hz)",
            [Line(f[1:], white[1:], "measured"), Line(f[1:], np.sqrt(density[1:, 0]), "left")],
            (0.0, float(f[-1])), "Hz", marked=bands_hz, log=True, tall=False,
        ),
    ]  # fmt: skip
    said = f"{name}: {brief(size)} {unit} RMS is left, where sensor noise leaves {brief(noise)}"
    keys = (("left", "what is left"), ("measured", "white sensor noise, over frequency"), NOISE_KEY)
    return chart(said, panels, (*keys, *([("held", "most of it")] if bands_hz else [])), _part_shown(span, time))


def changed_power(c: Comparison) -> float:
    """Return the power of the difference that a finding makes in a channel, over its noise; what it improves first."""
    moved = float(np.sum(((c.after - c.before) / c.noise) ** 2))
    return max(power_explained(c), 1e-6 * moved)


def is_seen(c: Comparison) -> bool:
    """Return whether a channel is farther off without a finding than with it."""
    before, after = (float(np.sum((y - c.measured) ** 2)) for y in (c.before, c.after))
    return before > DECLARED_NOISE.unsure**2 * after


def loudest(time: Array, values: Array) -> slice:
    """Return the few seconds of times (n,) in which values (n,) are largest; all of them where they are slow."""
    if len(time) < 2:
        return slice(0, len(time))
    width = max(2, round(PAGE.excerpt_s / float(np.median(np.diff(time)))))
    if width >= len(time) or slow(time, values):
        return slice(0, len(time))
    power = np.concatenate([[0.0], np.cumsum(values**2)])
    inside = (time[width - 1 :] - time[: len(time) - width + 1]) < 1.2 * PAGE.excerpt_s  # not across a gap
    held = np.where(inside, power[width:] - power[: len(power) - width], -1.0)
    start = int(np.argmax(held))
    return slice(start, start + width)


def slow(time: Array, values: Array) -> bool:
    """Return whether most of the power of values (n,) is at less than one cycle an excerpt, a constant counted."""
    power = np.abs(np.fft.rfft(values)) ** 2
    power[1:] *= 2
    frequency = np.fft.rfftfreq(len(values), float(np.median(np.diff(time))))
    return float(power[frequency < 1 / PAGE.excerpt_s].sum()) > PAGE.most * float(power.sum())


__all__ = ["changed_power", "figure", "figures", "is_seen", "left_over", "loudest", "residual", "slow", "title"]
