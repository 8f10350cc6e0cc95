"""What a solved fit's covariance is, as far as single rows see it: their leverages."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.solve import ALGEBRA
from imubench.diagnosis.problem.batch_model import Model
from imubench.diagnosis.problem.bspline import SUPPORT
from imubench.diagnosis.solve.block_tridiagonal import Factor
from imubench.diagnosis.solve.bordered import Solution
from imubench.diagnosis.solve.linearize import Linear, Stack, chunk_knots
from imubench.diagnosis.solve.threads import side_by_side


def windows(diagonal: Array, right: Array, after: Array | None, width: int) -> Array:
    """Return the blocks (knots, 6 w, 6 w) of a symmetric band that rows touch which begin at some blocks' knots.

    Of these blocks `diagonal` (k, b, b) and `right` (k, c, c) are those of the band, `after` (b, b) is the diagonal's
    one beyond them; None: there is none, and rows that would reach there have nothing.
    """
    b, span = diagonal.shape[1], SUPPORT * width
    top = b - right.shape[1]
    later = diagonal[1:] if after is None else np.concatenate([diagonal[1:], after[None]])
    out = np.zeros((len(diagonal) * ALGEBRA.knots_per_block, span, span))
    for offset in range(ALGEBRA.knots_per_block):
        at, inside = offset * width, min(span, b - offset * width)
        some = out[offset :: ALGEBRA.knots_per_block]
        some[:, :inside, :inside] = diagonal[:, at : at + inside, at : at + inside]
        if inside < span:
            over = span - inside
            some[:, :inside, inside:] = right[:, at - top :, :over]
            some[:, inside:, :inside] = np.swapaxes(right[:, at - top :, :over], 1, 2)
            some[: len(later), inside:, inside:] = later[:, :over, :over]
    return out


def inverse_windows(factor: Factor, width: int) -> Iterator[Array]:
    """Yield the same of a factored matrix' inverse, by so many knots as rows are stacked by, the last ones first."""
    blocks, at_once = factor.inverse(), chunk_knots(width) // ALGEBRA.knots_per_block
    after = None
    for begin in reversed(range(0, len(factor.lower), at_once)):
        some = list(islice(blocks, min(at_once, len(factor.lower) - begin)))[::-1]
        diagonal, right = (np.stack(parts) for parts in zip(*some, strict=True))
        yield windows(diagonal, right, after, width)
        after = diagonal[0]


@dataclass(frozen=True)
class Marginals:
    """The covariance of a solved fit, as far as single rows see it."""

    factor: Factor  # of the splines' matrix
    reach: Array  # (knots, w, p): N^-1 B
    shared: Array  # (p, p)

    @classmethod
    def of(cls, solution: Solution, width: int) -> "Marginals":
        """Return the covariance that a factored arrow matrix stands for."""
        reach = solution.factor.backward(solution.half)
        p = reach.shape[2]
        reach = reach.reshape(len(reach) * ALGEBRA.knots_per_block, width, p)
        return cls(solution.factor, reach, np.asarray(np.linalg.inv(solution.schur), dtype=float))

    def leverages(self, parts: Sequence[Linear]) -> list[Array]:
        """Return the leverage (n, m) of every row of some parts, at most 1.

        Where next to nothing holds a spline, at its ends, rounding would make it anything.
        """
        out = [np.zeros(part.residual.shape) for part in parts]
        width, p = self.reach.shape[1:]
        wide = SUPPORT * width
        stack = Stack(parts)
        beyond = -(-len(self.reach) // stack.chunk) - -(-stack.knots // stack.chunk)  # where no row begins
        inverse = islice(inverse_windows(self.factor, width), beyond, None)

        def fill(at: tuple[int, Array]) -> None:
            (begin, near), (tall, places) = at, stack.piece(at[0])
            local, knots = tall[:, :, :wide], np.arange(begin, begin + len(tall))
            reach = self.reach[knots[:, None] + np.arange(SUPPORT)].reshape(len(tall), wide, p)
            rest = tall[:, :, wide : wide + p] - np.matmul(local, reach)
            hat = np.sum(np.matmul(local, near[: len(tall)]) * local, axis=2)
            hat += np.sum((rest @ self.shared) * rest, axis=2)
            for h, (some, place) in zip(out, places, strict=True):
                h[some] = np.clip(hat[place], 0.0, 1.0)

        for _ in side_by_side(fill, zip(reversed(stack.begins), inverse, strict=False)):  # down to the first row
            pass
        return out


def covariance_of(model: Model, schur: Array) -> Array:
    """Return the covariance (p, p) of all parameters from what solving for the splines leaves of their information.

    With D the priors' standard deviations no eigenvalue of D S D is below 1, for each prior is in S. Where a sensor is
    nearly exact S is a small difference of large matrices, and rounding may leave less than the priors alone.
    """
    std = np.concatenate([p.std for p in model.priors.values()])
    values, vectors = np.linalg.eigh(schur * np.outer(std, std))
    wide = std[:, None] * vectors / np.sqrt(np.maximum(values, 1.0))
    return np.asarray(wide @ wide.T, dtype=float)


def root(covariance: Array) -> Array:
    """Return W (k, k) with W W' a covariance: a standard deviation along each of its axes."""
    values, vectors = np.linalg.eigh(covariance)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))
