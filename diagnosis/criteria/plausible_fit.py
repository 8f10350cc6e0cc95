"""Whether what a fit found can be: laws that hold, numbers that are plausible."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from imubench.diagnosis.config.criteria import LAW
from imubench.diagnosis.config.shared import EVIDENCE, STATISTICS
from imubench.diagnosis.criteria.trial import Trial
from imubench.diagnosis.noise.coloured import off_none
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis, State
from imubench.diagnosis.problem.process_factors import state_rows
from imubench.effects.effect import Reading
from imubench.jets import Jet

TRIPLES = ("gyro", "accel")  # variants of a filter that delay one against the other: nothing else does
DELAYS = 3.0  # of its standard deviations, that a filter's delay must be


def law_levels(fit: Fit, hypotheses: Sequence[Hypothesis]) -> list[str]:
    """Return the names of the noise levels of some effects' laws."""
    return [n for h in hypotheses for n in fit.noise if n.startswith(f"{h.name}.")]


def holds_its_law(trial: Trial) -> bool:
    """Return whether every law holds, with plausible numbers, and a rate in Hz that its sensor's samples can show.

    A filter's cutoff must be known: what it delays by, 1 / (2 pi cutoff), is no more than nothing where that is not.
    A sensor on springs turns about a place within a hand of it, and its weight is in it: a law that asks for more
    stands for something else, and the model would be doubted for its numbers in the end.
    """
    fit, rates = trial.fit, {imu.name: imu.rate for imu in trial.fit.model.recording.imus}
    found = (trial.hypothesis, *trial.also)
    for h in found:
        if h.effect.straight_springs and not plausible(fit, h):
            return False
        apart = h.effect.variant in TRIPLES  # what delays one triple against the other is that, however quick
        for p in [p for p in h.effect.parameters if p.log]:
            value = fit.state.values[h.key(p.name)]
            most = rates.get(h.at, np.inf) / (2 if h.effect.filters else 1)  # above is a delay, which has a name
            unseen = p.unit == "Hz" and float(np.exp(value).min()) > most  # not on any axis
            if not apart and (unseen or np.all(np.abs(value - p.centre) > STATISTICS.rare_sigmas * p.std)):
                return False
            if h.effect.filters and 0.5 * off_none(fit, h.key(p.name)) ** 2 < EVIDENCE.state_nat:
                return False
    return all(left < max(STATISTICS.rare_sigmas, LAW.doubted_share * drive) for left, drive in laws(fit, found))


def plausible(fit: Fit, h: Hypothesis) -> bool:
    """Return whether no number of an effect, but for logarithms, is farther off its prior than chance leads."""
    off = [(fit.state.values[h.key(p.name)] - p.centre) / p.std for p in h.effect.parameters if not p.log]
    return all(bool(np.all(np.abs(x) <= STATISTICS.rare_sigmas)) for x in off)


def natural(fit: Fit, h: Hypothesis) -> bool:
    """Return whether an effect's numbers are physically possible.

    No friction that drives, no filter without a delay, no hum that the samples do not have.
    The states of a filter that is not there take in noise: its cutoff then does not differ from one without a delay.
    """
    if (h.effect.filters and off_none(fit, h.key("cutoff")) < DELAYS) or unheard(fit, h):
        return False
    sided = [h.key(p.name) for p in h.effect.parameters if p.sided]
    return all(bool(np.all(fit.state.values[name] >= 0.0)) for name in sided)


def unheard(fit: Fit, h: Hypothesis) -> bool:
    """Return whether a fitted hum is hardly in its accelerometer's samples: the motion would have to undo it.

    Where a measured pose counts less often than such a hum turns round, it follows a motion that hums only as an image
    of its own slower errors; a hum at the sensor that cancels that motion explains them. A motion knows of no hum: what
    the samples have in the phase of one, in a window of Hann's, is at least half of it.
    """
    imu = next((i for i in fit.model.recording.imus if h.effect.tone and i.name == h.at), None)
    if imu is None:
        return False
    model, state = fit.model, fit.state
    time = model.moment(state, imu.time, imu.name).time
    still = Jet(np.zeros((imu.time.size, 3)))
    hum = h.effect.error(Reading(still, still, time), model.values(h, state)).accel
    if hum is None:
        return False
    counts = (model.masks or {}).get(f"{imu.name}.accel", np.ones(imu.time.size, dtype=bool))
    place = (imu.time - imu.time[0]) / (imu.time[-1] - imu.time[0])
    weight = (counts * np.sin(np.pi * place) ** 2)[:, None]
    read = imu.accel - np.sum(weight * imu.accel, axis=0) / np.sum(weight)
    return bool(2 * np.sum(weight * read * hum.value) < np.sum(weight * hum.value**2))


def at_rest(fit: Fit, hypotheses: Sequence[Hypothesis]) -> State:
    """Return the fit's state with those of some effects at nought."""
    coefficients = fit.state.coefficients.copy()
    for h in hypotheses:
        for s in h.effect.states:
            coefficients[:, fit.model.tracks.columns(h.key(s.name))] = 0.0
    return replace(fit.state, coefficients=coefficients)


def laws(fit: Fit, hypotheses: Sequence[Hypothesis]) -> list[tuple[float, float]]:
    """Return what is left of each law of some effects, and what drives it (were their states at rest), in its stds.

    Foam is no linear spring: its law leaves several stds, which is little of what rocks an IMU on it.
    """
    rest = at_rest(fit, hypotheses)
    rows = [r for h in hypotheses for r in state_rows(fit.model, rest, h)]
    return [(fit.noise[r.name], float(np.sqrt(np.mean(r.whitened**2)))) for r in rows if r.name in fit.noise]
