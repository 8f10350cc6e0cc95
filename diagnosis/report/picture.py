"""A still picture of a diagnosis: measured, simulated without and with what was found, and the hinge axis after it."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from imubench.arrays import Array, rms
from imubench.atomic import atomic_file
from imubench.diagnosis.config.report import CHART
from imubench.diagnosis.evidence import Comparison, Evidence
from imubench.diagnosis.report import words
from imubench.diagnosis.report.compared import loudest
from imubench.diagnosis.report.numbers import brief, printed
from imubench.diagnosis.result import Diagnosis
from imubench.errors import InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MEASURED_COLOUR, BEFORE_COLOUR, AFTER_COLOUR, BAND_COLOUR = (
    "#1c2328",
    "#c8641e",
    "#1e7d4f",
    "#dde2e6",
)  # as on the report's page
PICTURE_INCHES = (9.0, 8.0)  # inches


def draw_diagnosis(path: Path, d: Diagnosis, evidence: Evidence, off: tuple[Array, Array], judge: str) -> None:
    """Write a PNG: a channel as measured and as simulated, what both models get wrong in it, and the hinge axis.

    Args:
        path: of the PNG; it appears whole or not at all.
        d: a diagnosis that found something.
        evidence: shown beside it, with MuJoCo's simulations.
        off: deg, by how much the estimated hinge axis is off at each IMU, (k,) without and (k,) with the findings.
        judge: what the axis is judged by, in words.

    Raises:
        InputError: matplotlib is not installed, or nothing was simulated.
    """
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise InputError("pictures: expected matplotlib, got none; pip install 'imubench[plot]'") from None
    if not evidence.simulated or d.simulation is None:
        raise InputError(f"{d.recording}: expected simulations to draw, got none")
    c, names = most_visible(d, evidence), [imu.name for imu in evidence.recording.imus]
    figure = Figure(figsize=PICTURE_INCHES, layout="constrained")
    signals, errors, axis = figure.subplots(3, 1, gridspec_kw={"height_ratios": [3, 2, 1.5]})
    draw_signals(signals, errors, c, evidence.span[0])
    draw_axis(axis, names, off, judge)
    found = words.listed([words.called(f.effect, f.at) for f in d.findings if f.named])
    seconds = evidence.span[1] - evidence.span[0]
    title = f"Found in {seconds:.0f} s of recording: {found}.\n{axis_change(off)}"
    figure.suptitle(title, fontweight="bold", ha="left", x=0.01)
    with atomic_file(Path(path)) as partial:
        figure.savefig(partial, dpi=CHART.dots_per_inch)


def most_visible(d: Diagnosis, evidence: Evidence) -> Comparison:
    """Return the channel that the declared model misses most, for its size: of a sensor at which something was found.

    A model that lacks what one sensor does moves the others too; where nothing sits at a sensor, all are asked.
    """
    found = {f.at for f in d.findings if f.named}
    own = [c for c in evidence.simulated if c.channel.partition(".")[0] in found]
    return max(
        own or evidence.simulated, key=lambda c: rms(c.before - c.measured) / max(float(np.std(c.measured)), c.noise)
    )


def draw_signals(signals: "Axes", errors: "Axes", c: Comparison, start: float) -> None:
    """Draw a channel where the declared model is farthest off, and beneath what each model gets wrong."""
    factor, unit = printed(c.unit)
    measured, before, after = (factor * y for y in (c.measured, c.before, c.after))
    some = loudest(c.time, before - measured)
    time = c.time[some] - start
    noise = factor * c.noise
    signals.plot(time, before[some], "--", color=BEFORE_COLOUR, lw=1.8, label="MuJoCo, as declared")
    signals.plot(time, after[some], color=AFTER_COLOUR, lw=1.8, label="MuJoCo, with what was found")
    signals.plot(time, measured[some], "o", color=MEASURED_COLOUR, alpha=0.6, ms=3, mew=0, label="measured")
    errors.axhspan(-2 * noise, 2 * noise, color=BAND_COLOUR, label="sensor noise, 95 % of it")
    errors.plot(time, (before - measured)[some], "--", color=BEFORE_COLOUR, lw=1.8)
    errors.plot(time, (after - measured)[some], color=AFTER_COLOUR, lw=1.8)
    without, with_it, level = (brief(size) for size in (rms(before - measured), rms(after - measured), noise))
    signals.set(ylabel=f"{words.spelled(c.channel)}, {unit}", xticklabels=[])
    errors.set(ylabel=f"simulated minus\nmeasured, {unit}", xlabel="time from the recording's start, s")
    errors.set_title(
        f"Over all {c.time[-1] - c.time[0]:.0f} s the simulation is off by {without} {unit} RMS as declared, "
        f"by {with_it} with what was found (noise {level})",
        loc="left",
        fontsize="medium",
    )
    for axes in (signals, errors):
        axes.set_xlim(time[0], time[-1])
        axes.spines[["top", "right"]].set_visible(False)
    signals.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3, frameon=False, borderaxespad=0.1)
    errors.legend(loc="lower right", frameon=False)


def draw_axis(axes: "Axes", names: Sequence[str], off: tuple[Array, Array], judge: str) -> None:
    """Draw by how much the hinge axis is off at every IMU, without and with the findings, in deg."""
    largest = max(float(np.max(values)) for values in off)
    rows = (
        (off[0], -0.2, BEFORE_COLOUR, "estimated from the recording as it is"),
        (off[1], 0.2, AFTER_COLOUR, "estimated with what was found taken out"),
    )
    for values, place, colour, label in rows:
        bars = axes.barh(np.arange(len(names)) + place, values, 0.38, color=colour, label=label)
        axes.bar_label(bars, [f"{value:.2f} deg" for value in values], padding=4)
    axes.set_yticks(range(len(names)), names)
    axes.set(xlabel=f"angle between the estimated hinge axis and {judge}, deg", xlim=(0, 1.15 * largest))
    axes.invert_yaxis()
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, frameon=False, borderaxespad=0.1)
    axes.spines[["top", "right"]].set_visible(False)


def axis_change(off: tuple[Array, Array]) -> str:
    """Return in words how far the worse of both hinge axes is off without and with the findings."""
    before, after = (float(np.max(values)) for values in off)
    return f"The hinge axis is {before:.1f} deg off as recorded, and {after:.2f} deg with that taken out."


__all__ = ["axis_change", "draw_diagnosis", "most_visible"]
