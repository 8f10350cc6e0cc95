"""The numbers of a fitted effect, of the shapes and units that it declares."""

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.solve import ALGEBRA
from imubench.diagnosis.config.verdict import FINDINGS
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.problem.motion_prior import states_inside
from imubench.diagnosis.result import Parameter
from imubench.recording import Recording


def parameters(
    h: Hypothesis, fit: Fit, std: dict[str, Array], measured: Recording | None = None
) -> dict[str, Parameter]:
    """Return an effect's parameters, as its law has them in time, of the shapes that it declares, with their stds."""
    out, recording = {}, measured or fit.model.recording
    values = {p.name: fit.state.values[h.key(p.name)] for p in h.effect.parameters}
    changing = h.effect.changing(values, recording.imu(h.at)) if h.effect.place == "imu" else {}
    told = h.effect.in_time(values, fit.model.tracks.knots.step)
    for p in h.effect.parameters:
        if p.reported:
            value, error = told[p.name], np.hypot(std[h.key(p.name)], changing.get(p.name, 0.0))
            if p.log:
                value = np.exp(value)
                error = error * value
            out[p.name] = Parameter(value.reshape(p.shape), error.reshape(p.shape), p.unit)
    if h.effect.found:
        states = states_inside(fit.model, fit.state, h)
        read = h.effect.read(values, states, fit.model.tracks.knots.step)
        units = {f.name: f.unit for f in h.effect.found}
        errors = h.effect.read_error(values, states, fit.model.tracks.knots.step)
        if not h.effect.states:
            errors = propagated_std(h, values, std, fit.model.tracks.knots.step) | errors
        for name, value in read.items():
            out[name] = Parameter(value, errors.get(name, np.abs(value) * FINDINGS.read_off_std), units[name])
    return out


def propagated_std(h: Hypothesis, values: dict[str, Array], std: dict[str, Array], step: float) -> dict[str, Array]:
    """Return the standard deviations of what is read off fitted numbers, each of these moved by a part of its own."""
    told = h.effect.read(values, {}, step)
    variance = {name: np.zeros_like(value) for name, value in told.items()}
    for key, value in values.items():
        for i, own in enumerate(std[h.key(key)]):
            moved = value + ALGEBRA.difference * own * (np.arange(value.size) == i)
            for name, x in h.effect.read(values | {key: moved}, {}, step).items():
                variance[name] += ((x - told[name]) / ALGEBRA.difference) ** 2
    return {name: np.sqrt(v) for name, v in variance.items()}
