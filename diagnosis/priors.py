"""What a fit holds to be plausible before it sees a measurement, as rows."""

from collections.abc import Iterator

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.kinematics import ATTITUDE, HINGE, POSITION
from imubench.diagnosis.model import Model, State
from imubench.diagnosis.rows import Rows
from imubench.diagnosis.splines import Moment
from imubench.jets import CONSTANT, Jet, dot, variable

SMOOTH = 4  # order of the derivative that is taken for white: acceleration falls with the square of the frequency
UNIT = 0.1  # how closely an attitude's quaternion keeps its norm; only holds a direction without meaning
ROOM = 3.0  # m, how far a joint centre that nobody measured strays, as far as a second later is another draw
HEADING = 1.0  # of the first quaternion: holds the heading, which nothing may see


def middles(model: Model) -> Array:
    """Return the middles (n,) s of the intervals between knots."""
    knots = model.tracks.knots
    return np.asarray(knots.start + knots.step * (np.arange(knots.count - 5) + 0.5), dtype=float)


def prior_rows(model: Model, state: State, noise: dict[str, float], anchor: Array | None) -> Iterator[Rows]:
    """Yield the rows of every prior: parameters, smoothness, norm, room, heading.

    `anchor` (4,) is the first attitude of the start. `noise` has each spline's roughness under "smooth.NAME".
    """
    for name, prior in model.priors.items():
        jet = variable((name, CONSTANT), state.values[name]) - prior.start
        yield Rows(f"prior.{name}", np.zeros(1), jet, prior.std, counts=False)
    time, step = middles(model), model.tracks.knots.step
    moment = Moment(model.tracks, state.coefficients, Jet(time[:, None]))
    for name, width in model.tracks.widths.items():
        density = noise[f"smooth.{name}"]
        yield Rows(f"smooth.{name}", time, moment.track(name, SMOOTH), np.full(width, density / np.sqrt(step)), False)
    if ATTITUDE in model.tracks.widths:
        q = moment.track(ATTITUDE)
        yield Rows("norm", time, dot(q, q) - 1.0, np.full(1, UNIT), False)
        if anchor is not None:
            first = Moment(model.tracks, state.coefficients, Jet(time[:1, None])).track(ATTITUDE)
            yield Rows("heading", time[:1], first - anchor, np.full(4, HEADING), False)
    if POSITION in model.tracks.widths and not any(p.position is not None for p in model.recording.poses):
        yield Rows("room", time, moment.track(POSITION), np.full(3, ROOM / np.sqrt(step)), False)
    for h in model.hypotheses:
        for s in h.effect.states:
            name = h.key(s.name)
            yield Rows(f"size.{name}", time, moment.track(name), np.full(s.width, s.std / np.sqrt(step)), False)


START_SMOOTH = {ATTITUDE: 3e4, POSITION: 3e4, HINGE: 3e4}  # rad or m / s^4 per root Hz: before it is estimated
