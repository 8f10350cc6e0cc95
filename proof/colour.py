"""Coloured noise in what can be seen at best: unknown like the motion, but with a law and a size that are known.

Each axis of an IMU reads c besides white noise, in units of its std: c_t = k c_(t-1) + sqrt(1 - k^2) e_t, e of std 1.
As unknowns with that law for rows, one for each sample, they keep the normal equations sparse, and what they leave of a
change is whitened exactly.
"""

from dataclasses import replace

import numpy as np
from scipy.sparse import block_diag, csc_matrix, diags, hstack, identity, vstack

from imubench.proof.linearised import Block
from imubench.proof.played import Case
from imubench.proof.sensors import kept, noise_std


def with_colour(A: csc_matrix, case: Case, parts: list[Block]) -> csc_matrix:
    """Return A (rows, x) with c among the unknowns and its laws below: (rows + c, x + c); A where noise is white."""
    options = replace(case.options, noise=1.0)
    if not options.colour:
        return A
    reads, laws, first = [], [], 0
    for block in parts:
        count = block.S[0].shape[0] * block.S[0].shape[1]
        at, _, channel = block.name.partition(".")
        if channel:
            m, rate = len(block.time), case.rates[int(at[-1]) - 1]
            keep = kept(m, channel, at, rate, case.seed, options.corner)
            _, usual = noise_std(channel, at, [], options)
            size = usual * np.sqrt(options.colour) / block.std
            above = csc_matrix((first, count))
            below = csc_matrix((A.shape[0] - first - count, count))
            reads.append(vstack([above, size * identity(count), below]))
            scale = np.where(np.arange(count) < 3, 1.0, 1 / np.sqrt(1 - keep**2))
            laws.append(diags(scale) @ (identity(count) - keep * diags(np.ones(count - 3), -3, shape=(count, count))))
        first += count
    law = block_diag(laws)
    return csc_matrix(vstack([hstack([A, *reads]), hstack([csc_matrix((law.shape[0], A.shape[1])), law])]))


__all__ = ["with_colour"]
