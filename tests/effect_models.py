"""A rig with an effect on it, in any state: what the tests of effects are asked of."""

from collections import defaultdict

import numpy as np

from imubench import rotations
from imubench.diagnosis.equations import equation_rows
from imubench.diagnosis.hypothesis import Hypothesis, State
from imubench.diagnosis.kinematics import ATTITUDE
from imubench.diagnosis.priors import prior_rows
from imubench.diagnosis.start import model_of
from imubench.recording import Body, Encoder, Imu, Recording

RATE, SECONDS = 25.0, 0.6
GRAVITY = np.array([0.0, 0.0, -9.81])
BODY = Body(mass=1.2, com=[0.05, 0.02, -0.25], inertia=[0.03, 0.028, 0.002])


def recording_of(rig, **changes):
    rng = np.random.default_rng(8)
    time = np.arange(0.013, SECONDS, 1 / RATE)
    names = ("imu1", "imu2") if rig == "hinge" else ("imu1",)
    imus = tuple(
        Imu(n, time + 0.003 * i, rng.normal(size=(len(time), 3)), rng.normal(size=(len(time), 3)), RATE,
            mount_position=rng.normal(size=3) * 0.1, mount_quaternion=rotations.random(rng))
        for i, n in enumerate(names)
    )  # fmt: skip
    swinging = rig != "free"
    encoders = (Encoder("hinge", time, rng.normal(size=len(time))),) if rig == "hinge" else ()
    given = {"imus": imus, "encoders": encoders, "body": BODY if swinging else None}
    return Recording("r", rig, **given | {"free_swings": ((0.0, SECONDS),) if swinging else ()} | changes)


def model_with(effect, rig, **changes):
    recording = recording_of(rig, **changes)
    places = effect.places(recording)
    model = model_of(recording, knots_per_s=20.0)
    return model.with_effects((Hypothesis(effect, places[-1]),)) if places else None


def random_state(model, rng, size=0.5):
    """A motion of some rad/s about level, every parameter half a prior's std from its start."""
    tracks = model.tracks
    coefficients = 0.3 * rng.normal(size=(tracks.knots.count, tracks.width))
    if ATTITUDE in tracks.widths:
        coefficients[:, tracks.columns(ATTITUDE)] *= 0.3
        coefficients[:, tracks.columns(ATTITUDE)] += [1.0, 0.0, 0.0, 0.0]
    for h in model.hypotheses:
        for s in h.effect.states:
            coefficients[:, tracks.columns(h.key(s.name))] = s.std * rng.normal(size=(tracks.knots.count, s.width))
    values = {}
    for name, prior in model.priors.items():
        known = any(name.startswith(h.name) for h in model.hypotheses)
        values[name] = prior.start + size * (prior.std if known else 0.01) * rng.normal(size=len(prior.start))
        if name.endswith((".time", ".angle")):
            values[name][:] = 0.21 if name.endswith(".time") else 0.05  # within the recording; within reach
    return State(coefficients, values)


def every_row(model, state):
    """Measurements and laws; what the joint's centre obeys is the one prior that an effect enters."""
    drift = [r for r in prior_rows(model, state, defaultdict(lambda: 1.0), None) if r.name == "drift"]
    return [*model.measured(state), *equation_rows(model, state), *drift]
