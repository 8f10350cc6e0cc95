"""Does it predict? Parameters from one part of the recording, judged on the rest.

The recording is cut into blocks of a few seconds. The parameters are fitted on every other block and
held; on the blocks left out only the motion is fitted. What an effect gains there, it cannot have
learnt there. Both halves take their turn.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from imubench.arrays import Array
from imubench.diagnosis.fit import Fit, solve
from imubench.diagnosis.model import Model

BLOCK = 5.0  # s
BLOCKS = 8  # at least, when the recording is short
DRAWS = 2000


@dataclass(frozen=True)
class Gain:
    """What a model gains over another on data that it did not see."""

    value: float  # nat
    low: float  # 95 % of block bootstraps lie between
    high: float
    blocks: Array  # (k,) nat, of each block


@dataclass(frozen=True)
class Held:
    """Half the squared residuals of each block, parameters from the other half, and how many numbers they are."""

    cost: Array  # (k,)
    count: Array  # (k,)
    rows: dict[str, list[tuple[Array, Array]]]  # per group: times and whitened residuals, as left out


def block_of(time: Array, start: float, end: float) -> NDArray[np.int64]:
    """Return the block that each time (n,) lies in."""
    length = min(BLOCK, (end - start) / BLOCKS)
    return np.floor(np.clip((time - start) / length, 0, (end - start) / length - 1e-9)).astype(np.int64)


def held_out(fit: Fit) -> Held:
    """Return how a model predicts each half of the recording from the other."""
    span = [r.time for r in fit.measured]
    start, end = min(t.min() for t in span), max(t.max() for t in span)
    count = int(block_of(np.array([end]), start, end)[0]) + 1
    cost, size = np.zeros(count), np.zeros(count)
    parts: dict[str, list[tuple[Array, Array]]] = {}
    for half in (0, 1):
        learnt = solve(_on(fit.model, start, end, half), fit.state, fit.noise, fit.anchor, steps=3)
        fixed = replace(_on(fit.model, start, end, 1 - half), fixed=learnt.state.values)
        judged = solve(fixed, replace(fit.state, values=learnt.state.values), fit.noise, fit.anchor, steps=3)
        for rows in judged.measured:
            block = block_of(rows.time, start, end)
            own = block % 2 == 1 - half
            square = 0.5 * np.sum(rows.whitened**2, axis=1)
            cost += np.bincount(block[own], square[own], count)
            size += np.bincount(block[own], minlength=count) * rows.residual.value.shape[1]
            parts.setdefault(rows.name, []).append((rows.time[own], rows.whitened[own]))
    return Held(cost, size, parts)


def gain(before: Held, after: Held, rng: np.random.Generator) -> Gain:
    """Return what `after` gains, with the interval of a bootstrap over blocks."""
    blocks = before.cost - after.cost
    draws = rng.choice(blocks, size=(DRAWS, len(blocks))).sum(axis=1)
    low, high = np.quantile(draws, [0.025, 0.975])
    return Gain(float(blocks.sum()), float(low), float(high), blocks)


def _on(model: Model, start: float, end: float, half: int) -> Model:
    """Return the model with the measurements of every other block only."""
    masks = {}
    for name, stamps in model.stamps.items():
        own = block_of(np.clip(stamps - model.start, start, end), start, end) % 2 == half
        masks[name] = own if model.masks is None or name not in model.masks else own & model.masks[name]
    return replace(model, masks=masks)


__all__ = ["Gain", "Held", "gain", "held_out"]
