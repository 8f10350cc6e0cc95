"""Recordings, truths, estimates, scores and diagnoses as figures of matplotlib."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from imubench.diagnosis.result import Diagnosis
from imubench.displays.displayed import missing
from imubench.displays.numbers import told
from imubench.displays.svg import COLOURS
from imubench.estimate import Estimate
from imubench.recording import Recording
from imubench.score import Score
from imubench.truth import Truth

if TYPE_CHECKING:
    from matplotlib.figure import Figure

XYZ = "xyz"


def plot(value: Any) -> Figure:
    """Return a figure of a value; `InputError` without matplotlib."""
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise missing("matplotlib", "plot", "plot") from None
    figure = Figure(figsize=(9, 4.5), layout="constrained")
    PLOTS[type(value)](value, figure)
    return figure


def _recording(r: Recording, figure: Figure) -> None:
    """Draw what each IMU read, over time, free swings shaded."""
    count = max(1, len(r.imus))
    figure.set_size_inches(9, 1 + 3 * count)
    panels = figure.subplots(2 * count, 1, sharex=True, squeeze=False)[:, 0]
    for i, imu in enumerate(r.imus):
        for panel, key, unit in zip(panels[2 * i :], ("gyro", "accel"), ("rad/s", "m/s²"), strict=False):
            _curves(panel, imu.time, getattr(imu, key), f"{imu.name} {key}\n{unit}")
            for start, end in r.free_swings:
                panel.axvspan(start, end, color="0.9", zorder=0)
    panels[-1].set_xlabel("time, s")
    figure.suptitle(f"{r.name}: {r.rig}")


def _truth(t: Truth, figure: Figure) -> None:
    """Draw the hinge angle where there is one, and the true rate of every sensor."""
    panels = figure.subplots((t.joint_angle is not None) + len(t.sensors), 1, sharex=True, squeeze=False)[:, 0]
    if t.joint_angle is not None:
        panels[0].plot(t.time, t.joint_angle, color=COLOURS[0], lw=0.9)
        panels[0].set_ylabel("hinge angle\nrad")
    for panel, sensor in zip(panels[-len(t.sensors) :], t.sensors, strict=True):
        _curves(panel, t.time, sensor.gyro, f"{sensor.name} true rate\nrad/s")
    panels[-1].set_xlabel("time, s")


def _curves(panel: Any, time: Any, values: Any, label: str) -> None:
    for k, axis in enumerate(XYZ):
        panel.plot(time, values[:, k], color=COLOURS[k], lw=0.8, label=axis)
    panel.set_ylabel(label)
    panel.legend(loc="upper right", ncols=3, frameon=False)


def _estimate(e: Estimate, figure: Figure) -> None:
    """Draw the components with their standard deviations; of a stream over time."""
    imus = e.value.shape[-2]
    unit = "m" if e.quantity == "joint_vector" else "1"
    panels = figure.subplots(1, imus, sharey=True, squeeze=False)[0]
    for i, panel in enumerate(panels):
        value = e.value[..., i, :]
        if e.time is not None:
            _curves(panel, e.time, value, f"imu{i + 1}, {unit}")
            panel.set_xlabel("time, s")
            continue
        block = None if e.covariance is None else np.diag(e.covariance)[3 * i : 3 * i + 3]
        std = None if block is None else np.sqrt(np.maximum(block, 0.0))
        panel.bar(list(XYZ), value, yerr=std, color=COLOURS, capsize=4)
        panel.axhline(0, color="0.6", lw=0.8)
        panel.set(title=f"imu{i + 1}", ylabel=unit)
    figure.suptitle(f"{e.quantity.replace('_', ' ')} by {e.estimator}: {e.status}")


def _score(s: Score, figure: Figure) -> None:
    """Draw each figure as a bar, in degrees and millimetres, a panel a unit."""
    shown = {name: told(value, s.units[name]) for name, value in s.figures.items()}
    units = list(dict.fromkeys(unit for _, unit in shown.values()))
    for panel, unit in zip(figure.subplots(len(units), 1, squeeze=False)[:, 0], units, strict=True):
        own = {name: value for name, (value, u) in shown.items() if u == unit}
        drawn = panel.barh(list(own), list(own.values()), color=COLOURS[0])
        panel.bar_label(drawn, [f"{value:.3g} {unit}" for value in own.values()], padding=4)
        panel.margins(x=0.15)
        panel.invert_yaxis()
        panel.set_xlabel(unit)
    figure.suptitle(f"{s.estimator}: how far its {s.quantity.replace('_', ' ')} is off")


def _diagnosis(d: Diagnosis, figure: Figure) -> None:
    """Draw by how much both simulations are off in each channel, in times its noise; without any, the misfit."""
    panel = figure.subplots()
    channels = d.simulation.channels if d.simulation is not None else {}
    noisy = {name: c for name, c in channels.items() if c.noise > 0}
    if noisy:
        figure.set_size_inches(9, 1.5 + 0.35 * len(noisy))
        rows = np.arange(len(noisy))
        panel.barh(rows - 0.2, [c.before / c.noise for c in noisy.values()], 0.4, color="0.7", label="as declared")
        after = [c.after / c.noise for c in noisy.values()]
        panel.barh(rows + 0.2, after, 0.4, color=COLOURS[0], label="with what was found")
        panel.set_yticks(rows, list(noisy))
        panel.set_xlabel("MuJoCo's simulation minus what was measured, RMS over the noise")
        panel.axvline(1.0, color="0.3", lw=0.8)
        panel.legend(frameon=False)
        panel.invert_yaxis()
    else:
        panel.bar(["as declared", "with what was found"], d.misfit, color=["0.7", COLOURS[0]])
        panel.set_ylabel("misfit of the fitted motion, 1 is only noise")
    found = ", ".join(f"{f.effect} at {f.at}" for f in d.findings[:3])
    figure.suptitle(f"{d.recording}: {d.verdict}" + (f" ({found})" if found else ""))


PLOTS: dict[type, Callable[[Any, Figure], None]] = {
    Recording: _recording,
    Truth: _truth,
    Estimate: _estimate,
    Score: _score,
    Diagnosis: _diagnosis,
}
"""What draws each type."""
