"""Which figure of a score a sweep shows: by default the one that sums up the IMUs of a rig."""

from collections.abc import Sequence

from imubench.errors import InputError, unknown
from imubench.estimate import Quantity
from imubench.estimators import Estimator
from imubench.score import BEST_PAIRING, Score

UNITS = {"joint_axis": "rad", "joint_vector": "m"}
DEFAULTS = {"joint_axis": "rmsae", "joint_vector": "error"}
KNOWN = {
    "joint_axis": dict.fromkeys(("rmsae", "maxae", "deviation"), "rad"),
    "joint_vector": {"error": "m", "length_error": "m", "angle_error": "rad"},
}
"""Quantity -> a figure without the name of its IMU, and its unit."""
WORDS = {
    "rmsae": "axis error, root mean square of both sensors",
    "maxae": "axis error, the larger of both sensors",
    "deviation": "axis error, the larger of both sensors",
    "error": "joint centre, the largest distance of any sensor",
    "length_error": "joint centre, the largest difference of length of any sensor",
    "angle_error": "joint centre, the largest difference of direction of any sensor",
}
IMUS = ("imu1", "imu2")
SHOWN = {"rad": ("deg", 57.29577951308232), "m": ("mm", 1e3)}


def figure_of(given: str | None, estimators: Sequence[Estimator], unit: str) -> str:
    """Return the figure that all estimators of a sweep are shown by.

    Args:
        given: what the spec says, None: nothing.
        estimators: whose quantities may be None, where an estimator from outside does not say.
        unit: rad or m, that of the spec's limit.

    Raises:
        InputError: estimators of two quantities, a figure that theirs has not, or a limit of another unit.
    """
    by_quantity: dict[Quantity, str] = {e.quantity: e.name for e in estimators if e.quantity is not None}
    if len(by_quantity) > 1:
        names = ", ".join(f"{quantity} of {name}" for quantity, name in by_quantity.items())
        raise InputError(f"--estimator: expected estimators of one quantity, got {names}")
    quantity = next(iter(by_quantity), "joint_axis" if unit == "rad" else "joint_vector")
    name = DEFAULTS[quantity] if given is None else given
    base, _ = _parts(name)
    if base not in KNOWN[quantity]:
        raise unknown(f"figure of a {quantity}", name, [*KNOWN[quantity], "and any of them with _imu1 or _imu2"])
    if KNOWN[quantity][base] != unit:
        right, wrong = (f"limit_{SHOWN[u][0]}" for u in (KNOWN[quantity][base], unit))
        raise InputError(f"limit: expected {right} for the {name} of a {quantity}, got {wrong}")
    return name


def words(figure: str) -> str:
    """Return what a figure is, in words."""
    base, imu = _parts(figure)
    return f"{base.replace('_', ' ')} of {imu}" if imu else WORDS[base]


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


def _parts(figure: str) -> tuple[str, str]:
    base, _, imu = figure.rpartition("_")
    return (base, imu) if imu in IMUS else (figure, "")
