"""What effects add to a fit's readings, and what others can make of it once motion and geometry have followed."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from imubench.arrays import Array
from imubench.diagnosis.config.solve import ALGEBRA
from imubench.diagnosis.problem.batch_model import Model
from imubench.diagnosis.problem.bspline import Tracks
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis, State
from imubench.diagnosis.problem.residuals import Parameters, Rows
from imubench.diagnosis.solve.gauss_newton import all_rows, extended
from imubench.diagnosis.solve.linearize import linearise
from imubench.diagnosis.solve.schur import Base, together
from imubench.diagnosis.solve.threads import one_thread
from imubench.jets import CONSTANT, Jet

MARK = "mark"

Columns = dict[str, dict[str, Array]]
"""What something adds to the model's readings (n, m), by its name and by group of measurements."""


@dataclass(frozen=True)
class JointInformation:
    """Hypotheses and columns after motion, geometry and every other effect have followed them."""

    places: dict[str, NDArray[np.int64]]  # of each hypothesis' parameters, and of each column
    information: Array  # (k, k)
    gradient: Array  # (k,)
    prior: Array  # (k,) standard deviations, infinite for columns

    def explained(self, wanted: Array, by: Array) -> tuple[float, Array]:
        """Return what is lost when directions (k, m) stand for a direction (k,), and their sizes (m,)."""
        weight = np.where(np.isfinite(self.prior), 1 / self.prior, 0.0)
        unit = by / np.maximum(np.sqrt(np.sum((weight[:, None] * by) ** 2, axis=0)), 1e-300)  # a prior's std each
        inner = unit.T @ self.information @ unit + (weight[:, None] * unit).T @ (weight[:, None] * unit)
        pull = unit.T @ self.information @ wanted
        size = np.linalg.solve(inner, pull)
        loss = 0.5 * float(wanted @ self.information @ wanted - pull @ size)
        return max(loss, 0.0), size * np.linalg.norm(unit, axis=0) / np.maximum(np.linalg.norm(by, axis=0), 1e-300)

    def along(self, *names: str) -> Array:
        """Return the directions (k, m) of the parameters or columns of these names."""
        return np.eye(len(self.prior))[:, np.concatenate([self.places[n] for n in names])]


@one_thread
def joint_information(
    model: Model, state: State, fit: Fit, fresh: Sequence[Hypothesis], columns: Columns | None = None
) -> JointInformation:
    """Return the information of hypotheses without states in `model`, and of columns, at a state, with a fit's noise.

    Of hypotheses some at a time, each with every column: what those of different pieces have in common is left out.
    """
    extra = columns or {}
    own = {h.key(p.name): p.width for h in fresh for p in h.effect.parameters}
    rows = all_rows(model, state, fit.noise, fit.anchor, fit.loose)
    kept = [_marked(r, extra) for r in rows if r.name not in {f"prior.{n}" for n in own}]
    others = model.with_effects(tuple(h for h in model.hypotheses if h not in fresh))
    base, none = Base.of(replace(fit, model=others, rows=kept)), Tracks(model.tracks.knots, {})
    every = Parameters(own | dict.fromkeys(extra, 1))
    information, gradient = np.zeros((every.count, every.count)), np.zeros(every.count)
    for some in list(together(fresh, ALGEBRA.columns)) or [[]]:
        names = [h.key(p.name) for h in some for p in h.effect.parameters] + list(extra)
        shared = Parameters({n: every.widths[n] for n in names})
        touched = (r for r in kept if any(n in shared.widths for n, _ in r.residual.blocks))
        told = ((r.name, linearise(r, none, shared).border) for r in touched)
        at = every.places(names)
        information[np.ix_(at, at)], gradient[at] = base.reduced(told, shared.count)
    prior = [model.priors[n].std for n in own] + [np.full(len(extra), np.inf)]
    places = {h.name + h.tag: every.places([h.key(p.name) for p in h.effect.parameters]) for h in fresh}
    places |= {n: every.places([n]) for n in extra}
    return JointInformation(places, (information + information.T) / 2, gradient, np.concatenate(prior))


def _marked(rows: Rows, columns: Columns) -> Rows:
    """Return rows that also depend on the columns."""
    blocks = {(n, CONSTANT): groups[rows.name][:, :, None] for n, groups in columns.items() if rows.name in groups}
    return replace(rows, residual=Jet(rows.residual.value, rows.residual.blocks | blocks)) if blocks else rows


def signature(fit: Fit, state: State, gone: Sequence[Hypothesis]) -> tuple[Model, State, dict[str, Array]]:
    """Return the model without some effects, its state at the same motion, and what they add to every group."""
    rest = tuple(h for h in fit.model.hypotheses if h not in gone)
    without = extended(replace(fit, state=state), rest)
    quiet = dict.fromkeys([*fit.noise, *without.noise], 1.0)
    own = [h.key("") for h in gone]
    rows = [all_rows(m, s, quiet, fit.anchor) for m, s in ((fit.model, state), (without.model, without.state))]
    has, lacks = ({r.name: r for r in some if not _of(r, own)} for some in rows)
    added = {n: has[n].residual.value - r.residual.value for n, r in lacks.items() if n in has}
    return without.model, without.state, {n: x for n, x in added.items() if np.any(x)}


def _of(rows: Rows, own: list[str]) -> bool:
    """Return whether rows are a prior or a law of these effects alone."""
    return any(
        rows.name.removeprefix(kind).startswith(key) for kind in ("", "prior.", "smooth.", "size.") for key in own
    )


__all__ = ["MARK", "Columns", "JointInformation", "joint_information", "signature"]
