"""Effects that act in a moment, as a slip does: which samples are left out for them, and whether they show there.

How a mount slips is not known to the sample. What it does from then on is fitted without the moment in which it acts;
that it did may be seen in that moment alone.
"""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from imubench.arrays import Array
from imubench.diagnosis.config.noise import MASKING
from imubench.diagnosis.config.shared import EVIDENCE
from imubench.diagnosis.config.solve import SOLVER
from imubench.diagnosis.problem.batch_model import Model
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.problem.residuals import CHANNELS
from imubench.diagnosis.solve.levenberg_marquardt import at_noise_of, solve
from imubench.diagnosis.windows import covered

Masks = dict[str, NDArray[np.bool_]]
"""The samples (n,) that count, by group."""


def mask_beside(fit: Fit, h: Hypothesis) -> Masks | None:
    """Return the samples that count besides those in which an effect acts as its law does not say; none: all do."""
    windows = fit.model.blind(h, fit.state)
    if not windows:
        return None
    masks = dict(fit.model.masks or {})
    for name, stamps in fit.model.stamps.items():
        if name.split(".")[0] == h.at:
            free = ~covered(stamps - fit.model.start, windows)
            masks[name] = free & masks.get(name, free)
    return masks


def weighed_beside(fit: Fit, hypotheses: Iterable[Hypothesis], sound: Masks | None) -> Fit:
    """Return the fit in which every sample counts as much as it tells of the motion beside some effects.

    What an effect's course is not known to be adds to the noise of the moment in which it acts; where that is far more
    than the noise, the samples are left out. What an effect hid comes back when the effect is dropped. A motion is
    anything where nothing is measured: a slip of 0.2 deg that leaves 0.4 s of samples out lets the joint turn by 5.

    Args:
        fit: with these effects in it.
        hypotheses: those that may act in a moment.
        sound: the samples that count beside no effect, by group; None: all.
    """
    masks, louder = dict(sound or {}), dict[str, Array]()
    for h in hypotheses:
        windows = fit.model.blind(h, fit.state)
        unsure = dict(zip(CHANNELS, fit.model.course_std(h, fit.state), strict=True))
        for name, stamps in fit.model.stamps.items() if windows else ():
            at, part = name.split(".")
            if at != h.at:
                continue
            acts = covered(stamps - fit.model.start, windows)
            times = float(np.hypot(1.0, unsure[part] / fit.noise[name]))
            if times > MASKING.left_out_noise:
                masks[name] = masks.get(name, np.ones(len(stamps), dtype=bool)) & ~acts
            else:
                louder[name] = louder.get(name, np.ones(len(stamps))) * np.where(acts, times, 1.0)
    model = replace(fit.model, masks=masks or None, louder=louder or None)
    return fit if _alike(model, fit.model) else solve(model, fit.state, fit.noise, fit.anchor, steps=SOLVER.few_steps)


def _alike(one: Model, other: Model) -> bool:
    """Return whether samples count alike in two models of a recording."""

    def weights(model: Model, name: str, n: int) -> Array:
        counts = (model.masks or {}).get(name, np.ones(n, dtype=bool))
        return np.where(counts, (model.louder or {}).get(name, np.ones(n)), np.inf)

    names = {name: len(stamps) for name, stamps in one.stamps.items()}
    return all(np.array_equal(weights(one, name, n), weights(other, name, n)) for name, n in names.items())


def shows_in_its_moments(fit: Fit, first: Fit, h: Hypothesis) -> bool:
    """Return whether what an effect does in the moments in which it acts anyhow is there, and is what its law says.

    There the fit leaves about as much as elsewhere if the law has the course of what happened, and several times as
    much where it only stands for something else.
    """
    windows = first.model.blind(h, first.state)
    if not windows:
        return False
    before = {r.name: r for r in at_noise_of(fit, first).measured}
    won = left = usual = 0.0
    for rows in (r for r in first.measured if r.name.split(".")[0] == h.at):
        acts = covered(rows.time, windows)
        square = np.sum(rows.whitened**2, axis=1)
        won += 0.5 * float(np.sum(before[rows.name].whitened[acts] ** 2) - square[acts].sum())
        left += float(square[acts].sum())
        usual += float(square[~acts].mean() * acts.sum())
    return won > EVIDENCE.clear_nat and left < MASKING.fits * usual


def with_mask(fit: Fit, counted: Masks | None) -> Fit:
    """Return the fit on those samples alone, noise levels as they were."""
    return solve(replace(fit.model, masks=counted), fit.state, fit.noise, fit.anchor, steps=SOLVER.few_steps)


__all__ = ["mask_beside", "shows_in_its_moments", "weighed_beside", "with_mask"]
