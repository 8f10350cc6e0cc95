"""Does it predict? Parameters from one part of the recording, judged on the rest.

The recording is cut into blocks of a few seconds. The parameters are fitted on every other block and
held; on the blocks left out only the motion is fitted. What an effect gains there, it cannot have
learnt there. Both halves take their turn. The equation of motion in free swings counts as data: it is where a torque
shows.

Each half's parameters are one Gauss-Newton step from those of the whole, exact where the rows are linear in
them. With N, B, C, g, h the normal equations of a half at the whole's solution (splines x, parameters p)::

    [ N   B ] [ x ]     [ g ]
    [ B'  C ] [ p ] = - [ h ]      learns p from that half,   x' - N'^-1 B' (p - p')   follows the other with it.
"""

import numpy as np
from numpy.typing import NDArray

from imubench.arrays import Array
from imubench.diagnosis.config.criteria import HELD_OUT
from imubench.diagnosis.criteria.trial import Gain
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.residuals import is_data
from imubench.diagnosis.solve.bordered import solve_arrow
from imubench.diagnosis.solve.levenberg_marquardt import at_noise_of
from imubench.diagnosis.solve.linearize import Linear, linearise
from imubench.diagnosis.solve.normal_equations import Normal
from imubench.diagnosis.solve.threads import one_thread


def block_of(
    time: Array, start: float, end: float, most: float = HELD_OUT.block_s, least: int = HELD_OUT.least_blocks
) -> NDArray[np.int64]:
    """Return the block that each time (n,) lies in; a block is `most` s long, or less so that they are `least`."""
    length = min(most, (end - start) / least)
    return np.floor(np.clip((time - start) / length, 0, (end - start) / length - 1e-9)).astype(np.int64)


def blocks_of(start: float, end: float, most: float = HELD_OUT.block_s, least: int = HELD_OUT.least_blocks) -> int:
    """Return how many blocks there are from a start to an end in s."""
    return int(block_of(np.array([end]), start, end, most, least)[0]) + 1


@one_thread
def held_out(
    fit: Fit,
    span: tuple[float, float] | None = None,
    most: float = HELD_OUT.block_s,
    least: int = HELD_OUT.least_blocks,
) -> Array:
    """Return half the squared residuals of each block (k,), parameters from the other half of the recording.

    `span` (start, end) s is divided into blocks of `most` s, `least` at least; None: the fit's own. Two fits are
    compared on the same.
    """
    start, end = span or fit.span
    model, count = fit.model, blocks_of(start, end, most, least)
    counted = [r for r in fit.rows if is_data(r)]
    blocks = [block_of(r.time, start, end, most, least) for r in counted]
    parts = [linearise(r, model.tracks, model.parameters) for r in counted]
    priors = [linearise(r, model.tracks, model.parameters) for r in fit.rows if not is_data(r)]
    halves = []
    for half in (0, 1):
        own = [part.of(block % 2 == half) for part, block in zip(parts, blocks, strict=True)]
        normal = Normal.of(model.tracks, model.parameters, own + priors)
        halves.append(half_step(normal)[:3])
        del normal  # with its factors, before the other half's: memory
    cost = np.zeros(count)
    for half, (motion, own_step, follow) in enumerate(halves):
        learnt = halves[1 - half][1]
        motion = motion + follow @ (learnt - own_step)
        for part, block in zip(parts, blocks, strict=True):
            own = block % 2 == half
            left = _left(part.of(own), motion, learnt, model.tracks.width)
            cost += np.bincount(block[own], 0.5 * np.sum(left**2, axis=1), count)
    return cost


def predicted(before: Fit, after: Fit, rng: np.random.Generator, most: float = HELD_OUT.block_s) -> Gain:
    """Return what a fit gains over another on what it did not see: left-out data, and what is declared of the rig.

    A declaration is a measurement too, made by the owner. A mount that is not where it is declared may fit the data
    as it is; only the declaration then speaks against it.
    """
    span = before.span
    return _beside_declared(before, after, gain(held_out(before, span, most), held_out(after, span, most), rng))


def by_halves(before: Fit, after: Fit, rng: np.random.Generator) -> Gain:
    """Return the same, each half of the recording foretold from the other.

    What adds up over the recording, as a bias of a gyroscope beside a measured attitude, shows in no block of two
    seconds, where the attitude at its beginning is free.
    """
    span = before.span
    return _beside_declared(
        before, after, gain(held_out(before, span, np.inf, 2), held_out(after, span, np.inf, 2), rng)
    )


def log_score_gain(before: Fit, after: Fit, rng: np.random.Generator, most: float = HELD_OUT.block_s) -> Gain:
    """Return the gain in the log density of left-out data, each fit at its own noise levels.

    It compares fits of which neither has all that the other has: no noise is common to them.
    """
    span = before.span
    one, two = (held_out(f, span, most) + _log_stds(f, span, most) for f in (before, after))
    return _beside_declared(before, after, gain(one, two, rng))


def _log_stds(fit: Fit, span: tuple[float, float], most: float) -> Array:
    """Return the summed logarithms of the standard deviations of each block's data (k,)."""
    count = blocks_of(*span, most)
    total = np.zeros(count)
    for r in (r for r in fit.rows if is_data(r)):
        total += np.bincount(block_of(r.time, *span, most), np.sum(r.log_std, axis=1), count)
    return total


def _beside_declared(before: Fit, after: Fit, found: Gain) -> Gain:
    """Return a gain on data, with what `after` gains by what is declared of the rig."""
    told = _declared(before) - _declared(after)
    return Gain(found.value + told, found.low + told, found.high + told, found.blocks)


def _declared(fit: Fit) -> float:
    """Return half the squared distances of the geometry from what is declared, in standard deviations."""
    return float(sum(r.cost for r in fit.rows if r.name.startswith("prior.") and "@" not in r.name))


def gain(before: Array, after: Array, rng: np.random.Generator) -> Gain:
    """Return what `after` gains by block (k,) over `before`, with the interval of a bootstrap over blocks."""
    blocks = before - after
    draws = rng.choice(blocks, size=(HELD_OUT.bootstrap_draws, len(blocks))).sum(axis=1)
    low, high = np.quantile(draws, [0.025, 0.975])
    return Gain(float(blocks.sum()), float(low), float(high), blocks)


def half_step(normal: Normal) -> tuple[Array, Array, Array, Array]:
    """Return the steps of the splines (m, b) and the parameters (p,) that a half alone asks for.

    With them what the splines do (m, b, p) when a parameter takes another step, and the parameters' information (p, p).
    """
    solution = solve_arrow(normal.band, normal.border, normal.corner)
    x, p = solution.solve(-normal.gradient[:, :, None], -normal.corner_gradient[:, None])
    return x[:, :, 0], p[:, 0], -solution.factor.backward(solution.half), solution.schur


def _left(part: Linear, motion: Array, learnt: Array, width: int) -> Array:
    """Return the residuals (n, m) after a step of the splines (m, b) and the parameters (p,)."""
    followed = part.along(motion.reshape(-1, width, 1))[:, :, 0]
    return np.asarray(part.residual + followed + part.border @ learnt)


def heldout_gain(fit: Fit, better: Fit, rng: np.random.Generator) -> Gain:
    """Return what a fit with more in it gains on held-out data, both at its noise levels."""
    return predicted(at_noise_of(fit, better), better, rng)


__all__ = ["block_of", "by_halves", "gain", "half_step", "held_out", "heldout_gain", "log_score_gain", "predicted"]
