"""A fit's residuals, motion, mounts and noise levels, as the report shows them."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from imubench import rotations
from imubench.arrays import Array
from imubench.diagnosis.discrepancy.terms import Unknown
from imubench.diagnosis.evidence import Comparison, Level, Played, Pose, Trace
from imubench.diagnosis.noise.noise_levels import levels
from imubench.diagnosis.problem.batch_model import SMOOTHING
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.residuals import Rows
from imubench.diagnosis.problem.rig_kinematics import FORCE, HINGE
from imubench.diagnosis.residual_checks.fitted_effects import fitted_effects
from imubench.diagnosis.result import NOT_KNOWN, Noise
from imubench.diagnosis.samples.rest_noise import quietest
from imubench.format1.profile_noise import by_profile
from imubench.recording import Recording

CHANNELS_WITH_UNIT = {
    "gyro": (("gyr_x", "gyr_y", "gyr_z"), "rad/s"),
    "accel": (("acc_x", "acc_y", "acc_z"), "m/s^2"),
    "angle": (("angle",), "rad"),
    "position": (("x", "y", "z"), "m"),
    "rotation": (("rx", "ry", "rz"), "rad"),
}


@dataclass(frozen=True)
class Weighed:
    """A fit's measurements beside their noise."""

    fit: Fit
    leverage: Mapping[str, Array]  # by group (n, k): how far a sample pulls the fit to itself
    levels: tuple[Level, ...]

    @property
    def misfit(self) -> float:
        """Residual power over noise power, freed from what the fit absorbs: 1 is only noise."""
        counts = {r.name: r.residual.value.size for r in self.fit.measured}
        powers = {level.group: (level.left / level.used) ** 2 for level in self.levels}
        return sum(counts[name] * self._power(name, power) for name, power in powers.items()) / sum(counts.values())

    @property
    def left_out(self) -> float:
        """The same with every sample predicted from all the others, r / (1 - h)."""
        used = {level.group: level.used for level in self.levels}
        power = {
            r.name: float(np.mean(r.residual.value**2 / np.maximum(1 - self.leverage[r.name], 1e-3)))
            / used[r.name] ** 2
            for r in self.fit.measured
        }
        counts = {r.name: r.residual.value.size for r in self.fit.measured}
        return sum(counts[n] * self._power(n, p) for n, p in power.items()) / sum(counts.values())

    def _power(self, name: str, power: float) -> float:
        return self.fit.model.averaging.power(name, power)


def weighed(fit: Fit, known: Mapping[str, float], seen: Mapping[str, float] | None = None) -> Weighed:
    """Return a fit beside the noise by group: the known level, else what the samples have `seen`, or the quietest's."""
    left, leverage = levels(fit)
    quiet = quietest(fit.model.recording.imus)
    table = []
    for rows in fit.measured:
        least = min(quiet.get(rows.name, np.inf), float(left[rows.name]))
        used = known.get(rows.name, (seen or {}).get(rows.name, least))
        unit = CHANNELS_WITH_UNIT[rows.name.split(".")[1]][1]
        table.append(Level(rows.name, unit, known.get(rows.name), used, float(left[rows.name])))
    return Weighed(fit, leverage, tuple(table))


def of_recording(weighed: Weighed) -> tuple[Level, ...]:
    """Return the levels of a fit's samples as the recording's have them."""
    out = []
    for level in weighed.levels:
        share = weighed.fit.model.averaging.share(level.group)
        told = None if level.declared is None else level.declared / share
        out.append(replace(level, declared=told, used=level.used / share, left=level.left / share))
    return tuple(out)


def noise_of(levels: Sequence[Level], recording: Recording, rested: Collection[str] = ()) -> dict[str, Noise]:
    """Return the noise that counts by triple, and how it is known.

    Args:
        levels: of every triple.
        recording: as it was read.
        rested: triples that have shown their noise at rest.
    """
    named = {f"{imu.name}.{key.removesuffix('_noise_std')}" for imu in recording.imus for key in by_profile(imu)}

    def source(level: Level) -> str:
        if level.declared:
            return "profile" if level.group in named else "declared"
        return "rest" if level.group in rested else NOT_KNOWN

    return {level.group: Noise(level.used, level.unit, source(level)) for level in levels}


def traces(before: Weighed, after: Weighed | None = None) -> tuple[Trace, ...]:
    """Return the residuals of the nominal fit, and those of the explained one beside them, on the first clock."""
    later = {} if after is None else {r.name: r for r in after.fit.measured}
    used = {level.group: level.used for level in before.levels}
    out = []
    for rows in before.fit.measured:
        at, part = rows.name.split(".")
        channels, unit = CHANNELS_WITH_UNIT[part]
        absorbed = float(np.mean(before.leverage[rows.name]))
        noise = used[rows.name] * float(np.sqrt(max(1 - absorbed, 1e-3)))
        other = later.get(rows.name)
        out.append(
            Trace(
                at,
                part,
                channels,
                unit,
                rows.time + before.fit.model.start,
                -rows.residual.value,
                noise,
                None if other is None else -_at_same_samples(rows, other),
            )
        )
    return tuple(out)


def _at_same_samples(rows: Rows, other: Rows) -> Array:
    """Return the other fit's residuals where these are; a changed mask or clock moves them by less than a sample."""
    if len(rows.time) == len(other.time):
        return other.residual.value
    return np.stack([np.interp(rows.time, other.time, x) for x in other.residual.value.T], axis=1)


def compared(
    time: Mapping[str, Array],
    measured: Mapping[str, Array],
    before: Mapping[str, Array],
    after: Mapping[str, Array],
    noise: Mapping[str, float],
    most: int = 1,
) -> tuple[Comparison, ...]:
    """Return the channels whose held-out error falls most, in units of their noise.

    All by group (imu2.accel): times (n,) s, samples (n, k), predictions of the models without and with a finding
    (n, k) on data that neither fit has seen, noise std.
    """
    found = []
    for group, std in noise.items():
        at, part = group.split(".")
        channels, unit = CHANNELS_WITH_UNIT[part]
        for i, channel in enumerate(channels):
            y, old, new = (x[group][:, i] for x in (measured, before, after))
            gain = float(np.mean((y - old) ** 2) - np.mean((y - new) ** 2)) / std**2
            found.append((gain, Comparison(f"{at}.{channel}", unit, time[group], y, old, new, std)))
    found.sort(key=lambda item: -item[0])
    return tuple(one for _, one in found[:most])


def replayed(numbers: Fit, nameless: Fit) -> Fit:
    """Return the fit whose motion and mounts a replay takes: that of what has no name, where something has none.

    Its signal is what a motion recovered with it leaves. Without one, the fit that the findings' numbers are of.
    """
    return nameless if any(isinstance(h.effect, Unknown) for h in nameless.model.hypotheses) else numbers


def played(fit: Fit) -> Played:
    """Return the recovered motion, two rows a knot; where no place is measured the joint stays and its force is told.

    Two, because a normalised quaternion between knots is no spline of theirs where the motion is rough. A pivot that
    moves is told by its force, too.
    """
    model = fit.model
    knots = model.tracks.knots
    time = np.asarray(model.start + knots.start + 0.5 * knots.step * np.arange(2 * (knots.count - 5) + 1))
    moment = model.moment(fit.state, time, "")
    first = model.segment(fit.state, moment, model.rig.tree.names[0])
    assert first.turn is not None  # every rig of the fit has an attitude
    q = rotations.continuous(np.broadcast_to(rotations.from_matrix(first.turn.matrix), (time.size, 4)))
    carried = any(h.effect.carries_joint for h in model.hypotheses)
    unplaced = FORCE in model.tracks.widths or carried
    place = np.zeros((1, 3)) if unplaced or first.position is None else first.position.value
    return Played(
        time,
        q,
        np.broadcast_to(place, (time.size, 3)),
        moment.track(HINGE).value[:, 0] if model.rig.hinge else None,
        first.force.value if unplaced else None,
        fitted_effects(fit, time - model.start),
    )


def mounts(fit: Fit) -> dict[str, Pose]:
    """Return the fitted mounts, before what an effect moves."""
    out = {}
    for imu in fit.model.recording.imus:
        base = fit.model.mounts[imu.name]
        turn = base.turn @ rotations.to_matrix(rotations.exp(fit.state.values[f"{imu.name}.rotation"]))
        out[imu.name] = Pose(base.position + fit.state.values[f"{imu.name}.translation"], rotations.from_matrix(turn))
    return out


def beside_motion(fit: Fit) -> tuple[str, ...]:
    """Return in words the numbers of a fit that are of its sensors' timing, and no findings."""
    values, out = fit.state.values, []
    for h in fit.model.hypotheses:
        if h.effect.given and h.effect.phrase:
            numbers = ((p, float(values[h.key(p.name)][0])) for p in h.effect.parameters)
            size = ", ".join(f"{p.name} {1e3 * x:+.2f} m{p.unit}" for p, x in numbers)
            out.append(f"The fit has {h.effect.phrase.format(imu=h.at)}: {size}.")
    for name in fit.model.smoothed:
        variance = 2 * float(values[f"{name}.{SMOOTHING}"][0])
        if variance > 0:
            out.append(f"The samples of {name} are smoothed, by a window of {1e3 * np.sqrt(variance):.1f} ms (std).")
    return tuple(out)
