"""What a sensor makes of a true motion, by the laws of the effects that were found at it; an IMU in this order::

    t' = clock(t)                    where in the world's time the stamp t is
    z = low-pass(true)               on the dense truth
    y = z(t') + errors(z(t'), t')    scale, misalignment, bias, drift, g-sensitivity, hum
    y = y + unknown(t)               the fitted signal
    y = y + knocks + noise
    y = clip(y), rounded
    drop-outs                        whole samples, missing or held

Rates in rad/s, specific forces in m/s^2, (n, 3), sensor axes. An encoder reads its own side of the joint, which behind
a backlash follows with free play.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.result import UNKNOWN
from imubench.effects import EFFECTS, VARIANTS, traits_of
from imubench.effects.effect import Effect, Reading
from imubench.effects.traits import Fault
from imubench.errors import InputError
from imubench.jets import Jet
from imubench.models.tree import rig_tree
from imubench.sim.imu_sampling import interpolate
from imubench.sim.swing import Torque
from imubench.truth import Truth


@dataclass(frozen=True)
class Link:
    """An effect at one IMU with its numbers."""

    effect: str
    values: Mapping[str, Array]  # parameter -> (k,)
    settings: Mapping[str, Any] = field(default_factory=dict)  # channels, mode
    time: Array = field(default_factory=lambda: np.zeros(0))  # (m,) s since the start, of a signal
    signals: Mapping[str, Array] = field(default_factory=dict)  # gyro, accel (m, 3), torque (m, 1); gap (m, 1) rad

    @property
    def law(self) -> Effect | None:
        """The law with these settings; None of what has none."""
        told = {key: _fixed(value) for key, value in self.settings.items() if value}
        for effect in (e for e in VARIANTS if e.name == self.effect):
            if told.items() <= {key: _fixed(value) for key, value in effect.settings.items()}.items():
                return effect
        return EFFECTS.get(self.effect)


def _fixed(setting: Any) -> Any:
    """Return a setting as it is compared: a list, as files have it, as a tuple."""
    return tuple(setting) if isinstance(setting, list) else setting


Chain = Sequence[Link]
Effects = tuple[tuple[str, Link], ...]
"""Places and the effects there: imu1, imu2, joint, body, world."""


def chained(name: str) -> bool:
    """Return whether an effect is played by an IMU's chain."""
    effect = EFFECTS.get(name)
    if effect is None or effect.place != "imu":
        return False
    return effect.acts("error", "clock", "filtered") or effect.fault is not None


def at_encoder(name: str) -> bool:
    """Return whether an effect stands between a joint and its encoder."""
    effect = EFFECTS.get(name)
    return effect is not None and effect.acts("encoder")


def moves_time(effects: Effects) -> bool:
    """Return whether a clock is off: then a sensor's first reading may be of a time before its first stamp."""
    laws = [law for _, link in effects if (law := link.law) is not None]
    return any(law.acts("clock") for law in laws)


def at_place(effects: Effects, place: str) -> tuple[Link, ...]:
    """Return the effects at a place."""
    return tuple(link for at, link in effects if at == place)


def read_by(
    truth: Truth,
    start: float,
    stamps: Array,
    name: str,
    chain: Chain,
    noise: tuple[float, float] = (0.0, 0.0),
    rng: np.random.Generator | None = None,
    first: float = 0.0,
) -> tuple[Array, Array, Array]:
    """Return the stamps (m,) s, rates and specific forces (m, 3) that an IMU reports.

    Args:
        truth: of the rig, dense and evenly spaced.
        start: s, in the stamps' own clock: drifts and clocks count from there.
        stamps: (n,) s, of the samples.
        name: of the sensor.
        chain: the effects at it.
        noise: std of a sample, rad/s and m/s^2; an effect of louder noise says another one.
        rng: for noise, knocks, lost samples and phases that nobody told; None: nothing of chance, no sample lost.
        first: s, how far behind `start` the truth's first row is.
    """
    sensor, step = truth.sensor(name), float(truth.time[1] - truth.time[0])
    dense = {"gyro": sensor.gyro, "accel": sensor.specific_force}
    laws = [(law, _jets(law, link, rng)) for link in chain if (law := link.law) is not None]
    time = Jet((stamps - start)[:, None])
    for law, known in laws:
        if known is not None:
            time = law.clock(time, known)
    for law, link in ((law, link) for link in chain if (law := link.law) is not None and law.filters):
        numbers = {p.name: np.asarray(link.values[p.name]).reshape(p.shape) for p in law.parameters}
        _, *both = law.corrupt(truth.time, dense["gyro"], dense["accel"], numbers, np.random.default_rng())
        dense = dict(zip(("gyro", "accel"), both, strict=True))
    at = np.clip(time.value[:, 0] - first, 0.0, truth.time[-1]) / step
    gyro, accel = interpolate(dense["gyro"], at), interpolate(dense["accel"], at)
    reading = Reading(Jet(gyro), Jet(accel), time)
    for law, known in laws:
        if known is None:
            continue
        error = law.error(reading, known)
        gyro = gyro if error.gyro is None else gyro + error.gyro.value
        accel = accel if error.accel is None else accel + error.accel.value
    for link in (x for x in chain if x.effect == UNKNOWN):
        for part, signal in link.signals.items():
            added = np.stack([np.interp(stamps - start, link.time, x) for x in signal.T], axis=1)
            gyro, accel = (gyro + added, accel) if part == "gyro" else (gyro, accel + added)
    return _sampled(stamps, gyro, accel, chain, noise, rng)


def angle_read(truth: Truth, start: float, stamps: Array, effects: Effects, first: float = 0.0) -> Array:
    """Return the angles (n,) rad that an encoder reads of a hinge, nothing of chance in them.

    Args:
        truth: of the rig, dense and evenly spaced.
        start: s, in the stamps' own clock, that effects count from.
        stamps: (n,) s, of the samples.
        effects: of which a backlash stands between the joint and the encoder.
        first: s, how far behind `start` the truth's first row is.

    Raises:
        InputError: for a rig without a hinge.
    """
    if truth.joint_angle is None:
        raise InputError(f"encoder: expected a hinge rig, got '{truth.rig}'")
    angle = truth.joint_angle
    for law, link in ((law, link) for _, link in effects if (law := link.law) is not None and law.acts("encoder")):
        begun = {name: np.asarray(np.interp(first, link.time, x[:, 0])) for name, x in link.signals.items()}
        angle = law.encoder_reads(angle, {**link.values, **begun})
    step = float(truth.time[1] - truth.time[0])
    return interpolate(angle[:, None], np.clip(stamps - start - first, 0.0, truth.time[-1]) / step)[:, 0]


def torque_of(effects: Effects, start: float) -> Torque | None:
    """Return the torque about a hinge's axis that was fitted without a name, N m by stamps (n,) s; None without.

    Args:
        effects: of the model.
        start: s, the stamp that a signal's time counts from.
    """
    own = [link for link in at_place(effects, "joint") if link.effect == UNKNOWN and "torque" in link.signals]
    if not own:
        return None
    return lambda stamps: np.sum([np.interp(stamps - start, x.time, x.signals["torque"][:, 0]) for x in own], axis=0)


def _jets(law: Effect, link: Link, rng: np.random.Generator | None) -> dict[str, Jet] | None:
    """Return the numbers of a law that adds to readings or moves their time; None where some are missing."""
    values = law.of_report(link.values, rng or np.random.default_rng(0))
    names = [p.name for p in law.parameters]
    if not set(names) <= set(values):
        return None
    return {name: Jet(np.asarray(values[name], dtype=float).reshape(1, -1)) for name in names}


def _sampled(
    stamps: Array, gyro: Array, accel: Array, chain: Chain, noise: tuple[float, float], rng: np.random.Generator | None
) -> tuple[Array, Array, Array]:
    """Return samples with what happens to them one by one."""
    std = list(noise)
    for fault in Fault:
        links = [x for x in chain if traits_of(x.effect).fault is fault]
        if fault is Fault.NOISY:
            for link in links:
                std[("gyro", "accel").index(traits_of(link.effect).channel)] = float(np.ravel(link.values["std"])[0])
            if rng is not None:
                gyro, accel = (x + s * rng.standard_normal(x.shape) for x, s in zip((gyro, accel), std, strict=True))
            continue
        for law, link in ((law, link) for link in links if (law := link.law) is not None):
            if fault.by_chance and rng is None:
                continue
            several = {f.name for f in law.found if f.shape}
            values = {k: np.asarray(v) if k in several else np.ravel(v)[0] for k, v in link.values.items()}
            stamps, gyro, accel = law.corrupt(stamps, gyro, accel, values, rng or np.random.default_rng(0))
    return stamps, gyro, accel


def plays(effect: str, rig: str) -> bool:
    """Return whether the replay of a `model/` has an effect of the library in it, on a rig."""
    known = EFFECTS.get(effect)
    if known is None or not known.fits(rig_tree(rig)):
        return False
    return known.in_the_rig or at_encoder(effect) or chained(effect)


__all__ = [
    "Chain",
    "Effects",
    "Link",
    "angle_read",
    "at_encoder",
    "at_place",
    "chained",
    "moves_time",
    "plays",
    "read_by",
    "torque_of",
]
