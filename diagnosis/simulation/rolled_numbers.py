"""The numbers of a model's two halves, and of its whole, learned from the free swings that are rolled out.

What judges a half is learned on the windows of the other half, and on its samples elsewhere (`shooting`). A model keeps
the numbers of its motion fit where it has a signal without a name, which is not played, or a sensor that slips, for no
law says how it reads meanwhile; and where a limb's roll-outs are far off: they are chaotic, and what such a model lacks
is not a milliradian of a mount.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from imubench.arrays import Array
from imubench.diagnosis.config.simulation import ROLL_OUT
from imubench.diagnosis.evidence import Swing
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.simulation.learned import Learned, Part, half_at, held_at, learned, numbers_of
from imubench.diagnosis.simulation.rollout import Misfit
from imubench.diagnosis.simulation.shooting import Shooting, Shot, at_numbers, known_outside
from imubench.diagnosis.simulation.sim_model import SimModel, named, sim_model
from imubench.diagnosis.solve.threads import one_thread

Halves = tuple[Learned, Learned]


class Judging(Protocol):
    """A recording that models are rolled out beside."""

    @property
    def parts(self) -> tuple[Part, ...]:
        """The halves of the recording."""

    def misfit(self, model: SimModel) -> Misfit:
        """Return a model's misfit of a window."""

    def begins(self, one: Learned, half: int) -> tuple[Swing, ...]:
        """Return a half's windows with the states at their starts that fit best with one model's numbers."""


def can_shoot(fit: Fit) -> bool:
    """Return whether all that a fit has in it is played, at every sample, and has numbers to be learned."""
    model = fit.model
    all_named = len(named(fit)) == len(model.hypotheses)
    return bool(model.parameters.count) and all_named and not any(model.blind(h, fit.state) for h in model.hypotheses)


def halves(
    judge: Judging, fit: Fit, known: Halves | None = None, started: Sequence[Sequence[Swing]] = ()
) -> tuple[Halves, Sequence[Sequence[Swing]]]:
    """Return a fit twice, as `learned`, with numbers from roll-outs where windows are rolled out, and these by half.

    Args:
        judge: of the recording, with the windows that are rolled out.
        fit: of the whole recording.
        known: what `learned` says of it, where that is known.
        started: the windows by half under that; to be found where they are not known.

    Raises:
        NotPositiveDefiniteError: where a half does not hold the motion.
        OutOfTime: where the time of the part of the work is spent.
    """
    known = known or learned(fit, judge.parts)
    started = started or [judge.begins(one, half) for half, one in enumerate(known)]
    shot = [_taught(judge, fit, one, half, started[1 - half]) for half, one in enumerate(known)]
    begun = [started[k] if one is known[k] else judge.begins(one, k) for k, one in enumerate(shot)]
    return (shot[0], shot[1]), begun


@one_thread
def _taught(judge: Judging, fit: Fit, one: Learned, half: int, windows: Sequence[Swing]) -> Learned:
    """Return the model that judges a half with numbers from the other half's windows, where they show any.

    The states at their starts are those of the other half's model, whose numbers are near.
    """
    found = shot(judge, fit, one.fit, windows, lambda time: half_at(judge.parts, time) != half, one.told)
    return one if found is None else replace(one, fit=held_at(fit, found.numbers))


@one_thread
def of_whole(judge: Judging, fit: Fit, after: Halves, started: Sequence[Sequence[Swing]]) -> Fit | None:
    """Return a fit with numbers from all windows; None where none are learned from roll-outs.

    None either where a model has what was known beforehand: its numbers on disk are sums with those of a baseline.

    Args:
        judge: of the recording, with the windows that are rolled out.
        fit: of the whole recording.
        after: its halves, with numbers from roll-outs.
        started: their windows by half.
    """
    if any(h.effect.given for h in fit.model.hypotheses):
        return None
    windows = [window for half in started for window in half]
    begun = at_numbers(fit, np.mean([numbers_of(one.fit) for one in after], axis=0))
    free = np.ones(fit.model.parameters.count, dtype=bool)
    found = shot(judge, fit, begun, windows, lambda time: np.ones(time.size, dtype=bool), free)
    return None if found is None else held_at(fit, found.numbers)


def shot(
    judge: Judging,
    fit: Fit,
    begun: Fit,
    windows: Sequence[Swing],
    teaches: Callable[[Array], NDArray[np.bool_]],
    free: NDArray[np.bool_],
) -> Shot | None:
    """Return the numbers that some windows show, from those in `begun`; None where they show none."""
    if not windows or not free.any() or not can_shoot(fit):
        return None
    model = sim_model(begun)
    off = np.concatenate([judge.misfit(model)(window)[1] for window in windows])
    if model.rig.tree.hinge is None and np.sqrt(np.mean(off**2)) > ROLL_OUT.near:
        return None
    return Shooting(begun, known_outside(fit, teaches, windows), judge.misfit, free).learned(windows)


__all__ = ["Halves", "can_shoot", "halves", "of_whole"]
