"""What a recording says of its sensors' own errors: all of them at once, those that nobody needed to find too.

Beside the effects of a fit every error that an IMU adds sample by sample and keeps (`of_the_sensor`) is put into the
model, and one Gauss-Newton step says what each is and how well that is known once motion, geometry and all else have
followed: N d = -g, covariance N^-1, N with the priors of the effects. Where the residuals are coloured it is as much
wider as each number's standard deviation is. A number that the recording could not show keeps its prior.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.noise.coloured import parameter_std
from imubench.diagnosis.problem.batch_model import Model, started
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.problem.motion_prior import TILT
from imubench.diagnosis.result import Own, Parameter, SensorErrors
from imubench.diagnosis.solve.gauss_newton import all_rows, factored
from imubench.diagnosis.solve.marginals import covariance_of
from imubench.diagnosis.solve.threads import one_thread
from imubench.effects import possible
from imubench.effects.effect import Effect
from imubench.recording import Imu


def samplewise(effect: Effect) -> bool:
    """Return whether an effect is the sensor's own and adds to each sample by itself."""
    return effect.of_the_sensor is not None and bool(effect.parameters) and not effect.states


@dataclass(frozen=True)
class _Part:
    """Some numbers of a fit, and what they are of an IMU's errors: M x + offset."""

    key: str
    matrix: Array  # (k, width)
    offset: Array  # (k,)


@one_thread
def own_errors(fit: Fit, imus: Sequence[Imu]) -> tuple[SensorErrors, ...]:
    """Return what a fit says of the errors of every IMU of a recording."""
    given = {h.at for h in fit.model.hypotheses if list(h.effect.known_parts())}
    names = {h.name for h in fit.model.hypotheses}
    every = [
        Hypothesis(effect, at)
        for effect, at in possible(fit.model.recording)
        if effect.place == "imu" and samplewise(effect)
    ]
    new = [h for h in every if h.at not in given and h.name not in names]
    model = fit.model.with_effects((*fit.model.hypotheses, *new))
    state = started(model, fit.state)
    rows = [r for r in all_rows(model, state, fit.noise, fit.anchor, fit.loose) if not r.name.startswith(TILT)]
    whole = replace(fit, model=model, state=state, rows=rows)
    normal, solution, _ = factored(model, rows)
    _, step = solution.solve(-normal.gradient[:, :, None], -normal.corner_gradient[:, None])
    covariance = covariance_of(model, solution.schur)
    del normal, solution  # memory
    white, wide = np.sqrt(np.diag(covariance)), np.ones(len(covariance))
    for name, std in parameter_std(whole).items():
        at = model.parameters.columns(name)
        wide[at] = np.maximum(std / white[at], 1.0)
    covariance = covariance * np.outer(wide, wide)
    return tuple(
        _errors_of(imu, [h for h in every if h.at == imu.name], model, state.values, step[:, 0], covariance)
        for imu in imus
    )


def _errors_of(
    imu: Imu, every: Sequence[Hypothesis], model: Model, values: dict[str, Array], step: Array, covariance: Array
) -> SensorErrors:
    parts = _parts(every, [h for h in model.hypotheses if h.at == imu.name])
    places = model.parameters.places([part.key for part in parts])
    matrix = np.concatenate([part.matrix for part in parts], axis=1)
    x = np.concatenate([values[part.key] for part in parts]) + step[places]
    total = matrix @ x + np.sum([part.offset for part in parts], axis=0)
    spread = matrix @ covariance[np.ix_(places, places)] @ matrix.T
    std = np.sqrt(np.diag(spread))
    errors, first = [], 0
    for h in every:
        told = {}
        for p in h.effect.parameters:
            own, first = slice(first, first + p.width), first + p.width
            told[p.name] = Parameter(total[own].reshape(p.shape), std[own].reshape(p.shape), p.unit)
        errors.append(Own(h.effect.name, imu.name, told))
    correlation = spread / np.outer(std, std)
    correlation = (correlation + correlation.T) / 2
    np.fill_diagonal(correlation, 1.0)
    return SensorErrors(imu.name, float(imu.rate), ranges_of(imu), tuple(errors), correlation)


def ranges_of(imu: Imu) -> dict[str, float]:
    """Return the declared ranges of an IMU's triples, rad/s and m/s^2."""
    return {part: limit for part, limit in (("gyro", imu.gyro_range), ("accel", imu.accel_range)) if limit}


def _parts(every: Sequence[Hypothesis], here: Sequence[Hypothesis]) -> list[_Part]:
    """Return the numbers of a model that are an IMU's errors, the order of `every` being that of these."""
    places, count = {}, 0
    for h in every:
        for p in h.effect.parameters:
            places[h.key(p.name)] = slice(count, count + p.width)
            count += p.width
    parts = []
    for h in here:
        if h.effect.given and list(h.effect.known_parts()):
            matrix, offset = np.zeros((count, h.effect.numbers)), np.zeros(count)
            for effect, p, share, expected in h.effect.known_parts():
                at = places[Hypothesis(effect, h.at).key(p.name)]
                matrix[at], offset[at] = share, expected
            parts.append(_Part(h.key(h.effect.parameters[0].name), matrix, offset))
        elif samplewise(h.effect):
            for p in h.effect.parameters:
                key = h.key(p.name)
                if key in places:
                    parts.append(_Part(key, np.eye(count)[:, places[key]], np.zeros(count)))
    return parts


__all__ = ["own_errors", "ranges_of", "samplewise"]
