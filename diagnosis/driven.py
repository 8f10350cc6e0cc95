"""Mounts on springs, scored before they are fitted: how the sensor would move if the nominal motion drove it.

A spring's response to a known drive is linear in an amplitude that the law says is one. Scoring that
amplitude per axis, over a grid of frequencies, says which sensor hangs on what and where to begin; the
exact refit then solves the sensor's own states. The same for a low-pass, whose first effect is a delay.
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from imubench.arrays import Array
from imubench.diagnosis.fit import Fit
from imubench.diagnosis.model import Hypothesis
from imubench.diagnosis.priors import middles
from imubench.diagnosis.splines import Moment
from imubench.effects.effect import Effect, Parameter, Scene, Values
from imubench.jets import Jet
from imubench.links import Link, shift, small_turn

FREQUENCIES = (4.0, 5.5, 7.5, 10.0, 13.0, 17.0, 22.0, 30.0)  # Hz, a third of an octave to a half apart
DAMPING = 0.15
AMPLITUDE = 1.0  # prior std of what the law says is one


@dataclass(frozen=True)
class Response:
    """A sensor's displacement or rotation (n, 3) and its derivatives over time, by splines."""

    splines: tuple[CubicSpline, ...]

    def at(self, time: Array) -> tuple[Array, ...]:
        """Return value, rate and acceleration (n, 3) at times (n,)."""
        return tuple(s(time) for s in self.splines)


class Driven(Effect):
    """A sensor that moves as a spring would let it, times an amplitude per axis."""

    place = "imu"
    parameters = (Parameter("amplitude", (3,), "1", AMPLITUDE),)

    def __init__(self, name: str, frequency: float, response: Response, turns: bool) -> None:
        self.name, self.law = name, "the response of springs and dampers to the nominal motion"  # type: ignore[misc]
        self.frequency, self.response, self.turns = frequency, response, turns

    def mount(self, link: Link, scene: Scene, p: Values) -> Link:
        moves = [p["amplitude"] * Jet(x) for x in self.response.at(scene.time.value[:, 0])]
        return link @ small_turn(*moves) if self.turns else shift(*moves) @ link


def responses(drive: Array, step: float, frequency: float) -> tuple[Array, Array, Array]:
    """Return x and its two derivatives (n, 3) for x'' + 2 z w x' + w^2 x = -drive (n, 3), without its mean."""
    n = len(drive)
    spectrum = np.fft.rfft(drive - drive.mean(axis=0), 2 * n, axis=0)
    w = 2 * np.pi * np.fft.rfftfreq(2 * n, step)[:, None]
    w0 = 2 * np.pi * frequency
    x = -spectrum / (w0**2 - w**2 + 2j * DAMPING * w0 * w)
    out = [np.fft.irfft((1j * w) ** k * x, 2 * n, axis=0)[:n] for k in range(3)]
    return out[0], out[1], out[2]


def driven(fit: Fit) -> list[Hypothesis]:
    """Return the hypotheses of springs under every IMU, over the grid of frequencies."""
    model, state = fit.model, fit.state
    time = middles(model)
    step = model.tracks.knots.step
    moment = Moment(model.tracks, state.coefficients, Jet(time[:, None]))
    segments = model.segments(state, moment)
    out = []
    for imu in model.recording.imus:
        segment = segments["segment2" if imu.name == "imu2" else "segment1"]
        link = model.mount(imu, state, moment, segment)
        sensor = segment.child(link)
        rows = (len(time), 3)
        force = np.broadcast_to(link.turn.forth(sensor.force).value, rows)
        turning = np.broadcast_to(sensor.accel.value, rows)
        for name, drive, turns in (("soft_mount", force, False), ("rocking_mount", turning, True)):
            for f in FREQUENCIES:
                if f > 0.4 / step:
                    continue
                splines = tuple(CubicSpline(time, x) for x in responses(drive, step, f))
                effect = Driven(name, f, Response(splines), turns)
                out.append(Hypothesis(effect, imu.name, f"~{f:g}"))
    return out
