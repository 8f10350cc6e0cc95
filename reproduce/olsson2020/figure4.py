"""Figure 4: the angular rates of the 14 motions."""

from typing import TYPE_CHECKING

import numpy as np

from imubench.reproduce.olsson2020 import data
from imubench.reproduce.olsson2020.results import Results
from imubench.reproduce.olsson2020.style import SEGMENT1, SEGMENT2, mark_sections, plain
from imubench.reproduce.paper import Figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing


def exhibit(r: Results) -> Figure:
    """Return figure 4."""
    whole = data.sequence("sequence1", r.settings.seed)
    motions = data.motions_of("sequence1", r.settings.seed)
    rates = np.stack([np.linalg.norm(imu.gyro, axis=1) for imu in whole.recording.imus])
    slow, fast = (
        np.sqrt(np.mean(rates[:, np.isin(motions, which)] ** 2)) for which in ((2, 3, 4, 5, 6, 7), range(9, 15))
    )
    pace = f"The fast motions 9 to 14 turn {fast / slow:.1f} times as fast as 2 to 7"
    finding = f"{pace}; in 1 and 8 the system rests, in 2 and 9 it turns as one body"
    text = (
        "Angular rates as the two simulated gyroscopes read them. In the sequential motions 3, 4, 10 and 11 segment 1 "
        "turns first and segment 2 after it. The motions are drawn anew: the paper's data are not published."
    )
    return Figure("figure4", "Figure 4", finding, text, lambda: draw(r))


def draw(r: Results) -> "Drawing":
    """Draw both rates over sequence 1."""
    from matplotlib.figure import Figure as Canvas

    whole = data.sequence("sequence1", r.settings.seed)
    figure = Canvas(figsize=(12, 4.2), layout="constrained")
    for axes, imu, colour, label in zip(
        figure.subplots(2, 1, sharex=True, sharey=True), whole.recording.imus, (SEGMENT1, SEGMENT2), (1, 2), strict=True
    ):
        axes.plot(imu.time, np.linalg.norm(imu.gyro, axis=1), color=colour, lw=0.4)
        axes.set_ylabel(f"$\\|\\omega_{label}\\|$, rad/s")
        axes.set_xlim(0, whole.duration)
        plain(axes)
        mark_sections(axes, whole.sections, numbers=label == 1)
    axes.set_xlabel("time, s")
    axes.set_ylim(0, None)
    return figure
