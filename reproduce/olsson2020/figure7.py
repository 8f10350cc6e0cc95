"""Figure 7: which samples are held, over time."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from imubench.reproduce.olsson2020 import data
from imubench.reproduce.olsson2020.measures_time import preference_for_rest, uninformative_gyro_samples
from imubench.reproduce.olsson2020.results import Results
from imubench.reproduce.olsson2020.settings import N_MAX, SEQUENCES
from imubench.reproduce.olsson2020.style import mark_sections
from imubench.reproduce.paper import Figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

BIN = 25  # samples in a column: half a second


def exhibit(r: Results) -> Figure:
    """Return figure 7."""
    useless, rest = uninformative_gyro_samples(r), preference_for_rest(r)
    kept = "none" if useless.value == 0 else f"{useless.value:.0f}"
    finding = (
        f"At the end {kept} of the held gyroscope samples come from motions that tell nothing, and rest holds "
        f"{rest.value:.1f} times its share of the accelerometer samples"
    )
    text = (
        f"Which samples Algorithms 2 and 3 hold with N_max = {N_MAX}: across, when a sample was measured; up, when one "
        f"looks. The darker, the more of the {BIN} samples of half a second are held. A vertical streak that "
        "ends: samples "
        "given up for better ones. Dashed lines and numbers: the motions."
    )
    return Figure("figure7", "Figure 7", finding, text, lambda: draw(r))


def density(held: NDArray[np.int_], samples: int) -> NDArray[np.float64]:
    """Return the part (seconds, bins) of the samples of each bin that are held, from numbers (seconds, n_max)."""
    bins = -(-samples // BIN)
    picture = np.zeros((len(held), bins))
    seconds, places = np.nonzero(held >= 0)
    np.add.at(picture, (seconds, held[seconds, places] // BIN), 1.0 / BIN)
    return picture


def draw(r: Results) -> "Drawing":
    """Draw sequences 1 and 2, gyroscope left and accelerometer right."""
    from matplotlib.figure import Figure as Canvas

    figure = Canvas(figsize=(12, 9), layout="constrained")
    for row, name, letter in zip(figure.subplots(2, 2, sharey="row"), SEQUENCES[:2], "ab", strict=True):
        end = r.sections(name)[-1].end
        samples = len(data.motions_of(name, r.settings.seed))
        for axes, kind in zip(row, ("gyro", "accel"), strict=True):
            picture = density(r.selected[name][kind].astype(int), samples)
            drawn = axes.imshow(
                np.sqrt(picture), cmap="Greys", vmin=0, vmax=1, origin="lower", extent=(0, end, 0, end), aspect="auto",
                interpolation="nearest",
            )  # fmt: skip
            mark_sections(axes, r.sections(name))
            axes.set_xlabel("time of the sample, s")
            axes.set_title({"gyro": "gyroscope, Algorithm 2", "accel": "accelerometer, Algorithm 3"}[kind], pad=16)
        row[0].set_ylabel(f"({letter}) sequence {name[-1]}\ntime at which one looks, s")
        bar = figure.colorbar(drawn, ax=row, pad=0.01, ticks=np.sqrt([0, 0.1, 0.25, 0.5, 1]))
        bar.ax.set_yticklabels(["0", "10", "25", "50", "100"])
        bar.set_label("% of the samples held")
    return figure
