"""One solution of a model: its state, what the noise was taken to be, and the rows there."""

from dataclasses import dataclass, field

from imubench.arrays import Array
from imubench.diagnosis.problem.batch_model import Model
from imubench.diagnosis.problem.hypothesis import State
from imubench.diagnosis.problem.residuals import Rows


@dataclass(frozen=True, eq=False)
class Fit:
    """A model, its best state, and what the noise was taken to be; one is another's equal only if it is that."""

    model: Model
    state: State
    noise: dict[str, float]  # std of each group of rows, in its unit
    cost: float
    steps: int
    anchor: Array | None = None
    loose: float = 1.0
    rows: list[Rows] = field(default_factory=list, repr=False)

    @property
    def knots(self) -> int:
        """How many knots the splines have."""
        return self.model.tracks.knots.count

    @property
    def span(self) -> tuple[float, float]:
        """First and last time of the measurements, in s on the splines."""
        return min(float(r.time.min()) for r in self.measured), max(float(r.time.max()) for r in self.measured)

    @property
    def measured(self) -> list[Rows]:
        """The rows of measurements."""
        return [r for r in self.rows if r.counts]
