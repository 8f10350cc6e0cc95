"""The figures of `imubench.score` by name: of which quantity they are, in which unit, and what people call them."""

from collections.abc import Mapping
from dataclasses import dataclass

from imubench.estimate import Quantity
from imubench.score import BEST_PAIRING, Score

IMUS = ("imu1", "imu2")


@dataclass(frozen=True)
class Figure:
    """A figure, without the name of an IMU."""

    quantity: Quantity
    unit: str  # rad or m
    words: str  # of all sensors of a rig together
    of_each: bool = True  # one for each IMU, whose name follows; False: one for all


FIGURES: Mapping[str, Figure] = {
    "rmsae": Figure("joint_axis", "rad", "axis error, root mean square of both sensors", of_each=False),
    "maxae": Figure("joint_axis", "rad", "axis error, the larger of both sensors", of_each=False),
    "deviation": Figure("joint_axis", "rad", "axis error, the larger of both sensors"),
    "error": Figure("joint_vector", "m", "joint centre, the largest distance of any sensor"),
    "length_error": Figure("joint_vector", "m", "joint centre, the largest difference of length of any sensor"),
    "angle_error": Figure("joint_vector", "rad", "joint centre, the largest difference of direction of any sensor"),
}
DEFAULTS: Mapping[Quantity, str] = {"joint_axis": "rmsae", "joint_vector": "error"}
"""The figure of a quantity that sums up the sensors of a rig."""


def of_quantity(quantity: Quantity) -> dict[str, str]:
    """Return the figures of a quantity, without the names of IMUs, and their units."""
    return {name: figure.unit for name, figure in FIGURES.items() if figure.quantity == quantity}


def scored() -> dict[str, Figure]:
    """Return every figure that a score can have, by its full name: with its IMU, and of the better of two pairings."""
    found: dict[str, Figure] = {}
    for prefix in ("", BEST_PAIRING):
        for name, figure in FIGURES.items():
            if prefix and figure.quantity != "joint_axis":
                continue
            names = [f"{name}_{imu}" for imu in IMUS] if figure.of_each else [name]
            found |= {f"{prefix}{one}": figure for one in names}
    return found


def parts(figure: str) -> tuple[str, str]:
    """Return a figure without the name of its IMU, and that name, empty where it has none."""
    base, _, imu = figure.rpartition("_")
    return (base, imu) if imu in IMUS else (figure, "")


def words(figure: str) -> str:
    """Return what a figure is, in words."""
    if figure.startswith(BEST_PAIRING):
        return f"{words(figure.removeprefix(BEST_PAIRING))}, how the signs of the axes go together left aside"
    base, imu = parts(figure)
    return f"{base.replace('_', ' ')} of {imu}" if imu else FIGURES[base].words


def value_of(score: Score, figure: str) -> tuple[float | None, bool]:
    """Return a figure in SI, and whether it is that of the better of two sign pairings; None where there is none.

    A figure without the name of an IMU is the largest of theirs, where the score has none for all.
    """
    for prefix in ("", BEST_PAIRING):
        own = {name: value for name, value in score.figures.items() if name.startswith(prefix)}
        name = prefix + figure
        if name in own:
            return own[name], bool(prefix)
        each = [own[f"{name}_{imu}"] for imu in IMUS if f"{name}_{imu}" in own]
        if each:
            return max(each), bool(prefix)
    return None, False
