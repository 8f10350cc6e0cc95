"""Figure 9: one second of a varying r by ArVE_d, in two planes."""

from typing import TYPE_CHECKING

import numpy as np

from imubench.reproduce.arve.results import Results
from imubench.reproduce.arve.settings import SPHERE
from imubench.reproduce.arve.style import ARVE_D, LIMIT_COLOUR, QUIET, plain
from imubench.reproduce.paper import Figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

START = 5.0  # s


def exhibit(r: Results) -> Figure:
    """Return figure 9."""
    distance = r.varying["arve-d"][..., 0]
    share = 100 * (distance < SPHERE).mean()
    finding = f"{share:.0f} % of the centres that ArVE_d finds are within 6 mm of the truth, not 93 %"
    text = (
        f"Run 1, one second from {START:.0f} s on: the centre seen from the sensor. Blue: ArVE_d; red: the truth, "
        "a line that is run along twice; grey: which belong together. The circle has the radius of 6 mm. The share is "
        f"that of all samples of {r.settings.runs} runs."
    )
    return Figure("figure9", "Figure 9", finding, text, lambda: draw(r))


def draw(r: Results) -> "Drawing":
    """Draw the planes x-z and y-z."""
    from matplotlib.figure import Figure as Canvas

    figure = Canvas(figsize=(12, 5.6), layout="constrained")
    first, time = int(r.varying["first"]), r.varying["time"]
    second = (time >= START) & (time < START + 1)
    truth, track = 1e3 * r.varying["truth"][second], 1e3 * r.varying["r arve-d"][0][second[first:]]
    for axes, i in zip(figure.subplots(1, 2), (0, 1), strict=True):
        pairs = np.stack([truth, track])
        axes.plot(pairs[..., i], pairs[..., 2], color=QUIET, lw=0.5, zorder=1)
        axes.plot(track[:, i], track[:, 2], ".", color=ARVE_D, ms=5, label="ArVE_d")
        axes.plot(truth[:, i], truth[:, 2], ".", color=LIMIT_COLOUR, ms=4, label="truth")
        x, z = truth[:, i].mean(), truth[:, 2].mean()
        turn = np.linspace(0, 2 * np.pi, 100)
        around = x + 1e3 * SPHERE * np.cos(turn), z + 1e3 * SPHERE * np.sin(turn)
        axes.plot(*around, color="#333333", lw=1.2, label="radius 6 mm")
        far = 1 + np.abs(pairs[..., [i, 2]] - [x, z]).max()
        axes.set_xlim(x - far, x + far)
        axes.set_ylim(z - far, z + far)
        axes.set_aspect("equal")
        axes.set_xlabel(f"$r_{'xy'[i]}$, mm")
        axes.set_ylabel("$r_z$, mm")
        axes.legend(fontsize=8, frameon=False, loc="upper left")
        plain(axes, "both")
    return figure
