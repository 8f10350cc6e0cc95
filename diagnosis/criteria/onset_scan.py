"""Columns that act from a moment on: what they promise, for many moments from one pass over the rows."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.solve import ALGEBRA
from imubench.diagnosis.problem.bspline import SUPPORT, Knots
from imubench.diagnosis.solve.bordered import tensor
from imubench.diagnosis.solve.linearize import Linear
from imubench.diagnosis.solve.schur import Base, promise


@dataclass(frozen=True)
class After:
    """Columns that act from a moment on, as what the samples at every knot have to do with them.

    A moment is taken to the next knot, a hundredth of a second away: where to begin is all that is asked.
    """

    base: Base
    knots: Knots
    cross: Array  # (knots, 6, width, r), the samples that start at a knot
    across: Array  # (knots + 1, p, r), those from a knot on
    corner: Array  # (knots + 1, r, r)
    gradient: Array  # (knots + 1, r)

    @classmethod
    def of(cls, base: Base, columns: Mapping[str, Array]) -> "After":
        """Return what further columns (n, m, r), whitened, by group of rows, have to do with a fit."""
        tracks, p = base.fit.model.tracks, base.fit.model.parameters.count
        count, r = tracks.knots.count, next(iter(columns.values())).shape[2]
        cross = np.zeros((count, SUPPORT, tracks.width, r))
        across, corner, gradient = (np.zeros((count + 1, *shape)) for shape in ((p, r), (r, r), (r,)))
        for group, column in columns.items():
            part = base.parts[group]
            for begin, products in part.by_knot(column):
                cross[begin : begin + len(products)] += products
            np.add.at(across, part.first, np.einsum("nmp,nmr->npr", part.border, column))
            np.add.at(corner, part.first, np.einsum("nmp,nmr->npr", column, column))
            np.add.at(gradient, part.first, np.einsum("nm,nmr->nr", part.residual, column))
        across, corner, gradient = (np.cumsum(x[::-1], axis=0)[::-1] for x in (across, corner, gradient))
        return cls(base, tracks.knots, cross, across, corner, gradient)

    def promises(
        self, moments: Array, prior: Array, begins: Mapping[str, Array] | None = None, within: float = 0.0
    ) -> list[float]:
        """Return what the columns promise from each of the moments on, in nat.

        `begins`: what they are instead in the `within` s before the moments, which must not overlap.
        """
        (count, _, width, r), solution = self.cross.shape, self.base.solution
        blocks, earlier = len(solution.factor.lower), int(np.ceil(within / self.knots.step)) + 1
        whole = np.zeros((blocks * ALGEBRA.knots_per_block + SUPPORT, width, r))
        for s in range(SUPPORT):
            whole[s : s + count] += self.cross[:, s]
        out = []
        together = max(self.base.at_once // r, 1)
        for some in np.array_split(moments, -(-len(moments) // together)):
            starts = np.floor((some - self.knots.start) / self.knots.step).astype(int)
            starts = np.clip(starts, 0, count - SUPPORT + 1)  # no sample starts there or later
            act = np.zeros((len(whole), width, len(some), r))
            for i, k in enumerate(starts):
                act[k + SUPPORT - 1 :, :, i] = whole[k + SUPPORT - 1 :]
                for s in range(SUPPORT - 1):
                    act[k + s : k + SUPPORT - 1, :, i] += self.cross[k : k + SUPPORT - 1 - s, s]
            across, corner, pull = self.across[starts], self.corner[starts], self.gradient[starts]
            for group, column in (begins or {}).items():
                for i, k in enumerate(starts):
                    part, own = self._just_before(group, k, earlier, column)
                    part.scatter(own, act[:, :, i])
                    across[i] += np.einsum("nmp,nmr->pr", part.border, own)
                    corner[i] += np.einsum("nmr,nms->rs", own, own)
                    pull[i] += np.einsum("nm,nmr->r", part.residual, own)
            target = act[: blocks * ALGEBRA.knots_per_block].reshape(blocks, -1, len(some) * r)
            taken = np.tensordot(self.base.step.splines, target, axes=2).reshape(-1, r)
            front = solution.factor.forward(target)
            for i, first in enumerate(np.maximum(starts - earlier, 0) // ALGEBRA.knots_per_block):
                own = front[first:, :, i * r : i * r + r]
                rest = across[i] - tensor(solution.half[first:], own)
                schur = corner[i] - tensor(own, own) - rest.T @ np.linalg.solve(solution.schur, rest)
                gradient = pull[i] + taken[i] + self.base.step.values @ across[i]
                out.append(promise((schur + schur.T) / 2, gradient, prior).evidence)
            del act, target, front  # before the next ones are made: memory
        return out

    def _just_before(self, group: str, knot: int, earlier: int, column: Array) -> tuple[Linear, Array]:
        """Return the rows of a group that start at so many knots before one, and what a column (n, m, r) is there."""
        part = self.base.parts[group]
        some = (part.first >= knot - earlier) & (part.first < knot)
        return part.of(some), column[some]
