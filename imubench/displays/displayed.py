"""What a class inherits to show itself. Nothing is imported until it is shown."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure


class Summarised:
    """A value whose arrays are too long to be printed: it prints itself in a line."""

    def __repr__(self) -> str:
        from imubench.displays.lines import line

        return line(self)


class Displayed:
    """A value with a table, a plot, and a small picture in a notebook."""

    def to_pandas(self) -> pandas.DataFrame:
        """Return the numbers as a table, SI units and radians.

        Raises:
            InputError: pandas is not installed; the message says what to install.
        """
        from imubench.displays.frames import frame

        return frame(self)

    def plot(self) -> Figure:
        """Return a figure that shows the numbers; `figure.savefig(PATH)` writes it.

        Raises:
            InputError: matplotlib is not installed; the message says what to install.
        """
        from imubench.displays.plots import plot

        return plot(self)

    def _repr_html_(self) -> str:
        from imubench.displays.html import page

        return page(self)


def missing(package: str, extra: str, what: str) -> Any:
    """Return the error for a package that only `what` needs."""
    from imubench.errors import InputError

    return InputError(f"{what}: expected {package}, got none; pip install 'imubench[{extra}]'")
