"""The effects of a fit with all that it says of them, as a replay needs them."""

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.discrepancy.terms import Unknown
from imubench.diagnosis.evidence import FittedEffect
from imubench.diagnosis.problem.bspline import Moment
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.jets import Jet

PARTS_OF_A_TERM = ("gyro", "accel", "torque")  # that a term without a name may add to


def fitted_effects(fit: Fit, time: Array) -> tuple[FittedEffect, ...]:
    """Return the effects of a fit with their states at `time` (n,) s since the recording's start.

    What is unknown is told at its sensor's own samples, or at its own times where it is a torque.
    """
    named = [h for h in fit.model.judged if not isinstance(h.effect, Unknown)]
    return (*(_named(fit, h, time) for h in named), *(_unknown(fit, h) for h in fit.model.judged if h not in named))


def _named(fit: Fit, h: Hypothesis, time: Array) -> FittedEffect:
    told = fit.model.values(h, fit.state)
    values = {p.name: told[p.name].value[0].reshape(p.shape) for p in h.effect.parameters}
    moment = Moment(fit.model.tracks, fit.state.coefficients, Jet(time[:, None]))
    states = {s.name: moment.track(h.key(s.name)).value for s in h.effect.states}
    return FittedEffect(h.effect.name, h.at, h.effect.variant, h.effect.settings, values, time, states)


def _unknown(fit: Fit, h: Hypothesis) -> FittedEffect:
    assert isinstance(h.effect, Unknown)
    values, time = fit.model.values(h, fit.state), h.effect.term.time
    for imu in fit.model.recording.imus:
        if imu.name == h.at:
            time = imu.time - fit.model.start
    added = {part: h.effect.added(part, Jet(time[:, None]), values) for part in PARTS_OF_A_TERM}
    signals = {part: np.asarray(jet.value) for part, jet in added.items() if jet is not None}
    return FittedEffect(h.effect.name, h.at, h.effect.variant, {}, {}, time, signals)


__all__ = ["fitted_effects"]
