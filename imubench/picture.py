"""A still picture of a run, for reports and first looks."""

from pathlib import Path

import numpy as np

from imubench.errors import InputError
from imubench.estimate import Estimate
from imubench.recording import Recording
from imubench.score import Score

COLOURS = {"imu1": "#1f6fb4", "imu2": "#c8641e"}


def draw_run(path: Path, recording: Recording, estimate: Estimate, score: Score) -> None:
    """Write a PNG: what the gyroscopes saw, how well the estimated axes explain it, and how far off they are.

    Raises `InputError` where matplotlib is not installed, saying what to install.
    """
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise InputError("pictures: expected matplotlib, got none; pip install 'imubench[plot]'") from None
    figure = Figure(figsize=(9, 6.4), layout="constrained")
    rates, across, errors = figure.subplots(3, 1, gridspec_kw={"height_ratios": [3, 3, 1.2]})
    for i, imu in enumerate(recording.imus):
        colour = COLOURS[imu.name]
        rates.plot(imu.time, np.rad2deg(np.linalg.norm(imu.gyro, axis=1)), color=colour, lw=0.8, label=imu.name)
        perpendicular = np.linalg.norm(np.cross(imu.gyro, estimate.value[i]), axis=1)
        style = "-" if i == 0 else "--"
        across.plot(imu.time, np.rad2deg(perpendicular), style, color=colour, lw=0.9, label=imu.name)
    rates.set(ylabel="angular rate, deg/s", title="What the gyroscopes read", xticklabels=[])
    across.set(
        ylabel="rate across the\nestimated axis, deg/s",
        xlabel="time, s",
        title="Across a true hinge axis both segments turn at the same rate: the curves lie on each other",
    )
    for axes in (rates, across):
        axes.legend(loc="upper right", ncols=2, frameon=False)
        axes.set_xlim(recording.imus[0].time[0], recording.imus[0].time[-1])
        axes.spines[["top", "right"]].set_visible(False)
    names = [imu.name for imu in recording.imus]
    degrees = [np.rad2deg(score.deviation(n) or 0.0) for n in names]
    bars = errors.barh(names, degrees, color=[COLOURS[n] for n in names])
    errors.bar_label(bars, [f"{d:.2f} deg" for d in degrees], padding=4)
    errors.set(xlabel="angle between the estimated and the true axis, deg", xlim=(0, max(*degrees, 0.1) * 1.25))
    errors.invert_yaxis()
    errors.spines[["top", "right"]].set_visible(False)
    figure.suptitle(
        f"{recording.name}: {estimate.estimator} finds the hinge axis to {max(degrees):.2f} deg", fontweight="bold"
    )
    figure.savefig(path, dpi=130)
