"""Laws as rows: what effects' states obey at every knot, and the equation of motion inside free swings."""

from collections.abc import Iterator

from imubench.diagnosis.model import Model, State
from imubench.diagnosis.rows import Rows


def equation_rows(model: Model, state: State) -> Iterator[Rows]:
    """Yield the rows of every law."""
    return
    yield
