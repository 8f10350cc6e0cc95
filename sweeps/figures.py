"""Which figure of a score a sweep shows: by default the one that sums up the IMUs of a rig."""

from collections.abc import Sequence

from imubench.errors import InputError, unknown
from imubench.estimate import Quantity
from imubench.estimators import Estimator
from imubench.figures import DEFAULTS, of_quantity, parts
from imubench.units import SHOWN


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
    known, (base, _) = of_quantity(quantity), parts(name)
    if base not in known:
        raise unknown(f"figure of a {quantity}", name, [*known, "and any of them with _imu1 or _imu2"])
    if known[base] != unit:
        right, wrong = (f"limit_{SHOWN[u][0]}" for u in (known[base], unit))
        raise InputError(f"limit: expected {right} for the {name} of a {quantity}, got {wrong}")
    return name
