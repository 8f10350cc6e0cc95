"""The model that a recording is held against: splines, geometry, hypothesised effects, and the rows they make."""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from imubench.arrays import Array
from imubench.chain_rule import carrier, chained
from imubench.diagnosis.config.solve import ALGEBRA, MOTION_PRIOR
from imubench.diagnosis.problem.averaging import AS_RECORDED, Averaging
from imubench.diagnosis.problem.bspline import Moment, Tracks
from imubench.diagnosis.problem.encoder_calibration import ERROR, misreads, read, spread
from imubench.diagnosis.problem.hypothesis import Geometry, Hypothesis, Prior, State
from imubench.diagnosis.problem.kept_motions import KEPT, key_of
from imubench.diagnosis.problem.pose_factors import Lasting, pose_errors, slopes, smoothing_std
from imubench.diagnosis.problem.residuals import Parameters, Rows
from imubench.diagnosis.problem.rig_kinematics import HINGE, HINGE_AXIS, POSITION, SWING_AXIS, Rig, swing
from imubench.diagnosis.samples.pose_correlation import GaussMarkov
from imubench.effects.effect import Reading, Scene, Values
from imubench.jets import CONSTANT, Jet, Turn, rotation, variable
from imubench.links import Link, Motion
from imubench.recording import Imu, Pose, Recording
from imubench.slope import slope_of

SMOOTHING = "smoothing"
POSE_PARTS = ("position", "rotation")


@dataclass(frozen=True)
class Model:
    """A recording's model; `rows` compares it with the measurements."""

    recording: Recording
    rig: Rig
    tracks: Tracks
    mounts: dict[str, Geometry]  # per IMU
    start: float  # s, the stamp that counts as zero
    least: Mapping[str, float] = field(default_factory=dict)  # noise std that each IMU has at least, by group
    hypotheses: tuple[Hypothesis, ...] = ()
    offsets: tuple[str, ...] = ()  # sensors whose clock may be off against the first's
    masks: dict[str, NDArray[np.bool_]] | None = None  # per "imu1.gyro" and so on: samples (n,) that count
    louder: Mapping[str, Array] | None = None  # times (n,) the noise of its group that a sample has, by group; None: 1
    humming: Mapping[str, float] = field(default_factory=dict)  # IMUs whose raw samples hum, and at how many Hz
    wander: Mapping[str, GaussMarkov] = field(default_factory=dict)  # "pose1" and so on whose errors last, and how
    smoothed: tuple[str, ...] = ()  # "pose1" and so on whose samples were smoothed
    averaging: Averaging = AS_RECORDED  # of the samples, where they are fewer than the recording's
    fixed: dict[str, Array] | None = None  # parameters that are known and not to be moved
    tilts: dict[str, Prior] | None = None  # pulls on parameters (diagnosis/noise/debias.py), no knowledge about them

    def with_effects(self, hypotheses: tuple[Hypothesis, ...]) -> "Model":
        """Return the same model with other effects in it, and their states among the splines."""
        widths = dict(self.rig.widths)
        for h in hypotheses:
            widths |= {h.key(s.name): s.width for s in h.effect.states}
        return replace(self, hypotheses=hypotheses, tracks=Tracks(self.tracks.knots, widths))

    def same_rows(self, other: "Model") -> bool:
        """Return whether another model has the same rows, but for the priors of its parameters, at the same state."""
        if self.tracks != other.tracks or len(self.hypotheses) != len(other.hypotheses):
            return False
        if any(a is not b for a, b in zip(self.hypotheses, other.hypotheses, strict=True)):
            return False
        parts = ("recording", "rig", "mounts", "start", "offsets", "masks", "louder", "wander", "smoothed")
        return all(getattr(self, part) is getattr(other, part) for part in parts)

    @property
    def judged(self) -> tuple[Hypothesis, ...]:
        """The effects that a diagnosis asks of whether they are there: all that are not known beforehand."""
        return tuple(h for h in self.hypotheses if not h.effect.given)

    @cached_property
    def priors(self) -> dict[str, Prior]:
        """Every parameter's prior, by name."""
        out: dict[str, Prior] = {}
        for imu in self.recording.imus:
            for part, declared, missing in (
                ("translation", imu.mount_position_std, MOTION_PRIOR.unknown_position_m),
                ("rotation", imu.mount_rotation_std, MOTION_PRIOR.unknown_rotation_rad),
            ):
                std = max(missing if declared is None else declared, 1e-6)
                out[f"{imu.name}.{part}"] = Prior(np.zeros(3), np.full(3, std))
        for name in self.offsets:
            out[f"{name}.offset"] = Prior(np.zeros(1), np.full(1, 0.05))
        if misreads(self.recording):
            out[ERROR] = Prior(np.zeros_like(spread()), spread())
        for name in self.smoothed:
            out[f"{name}.{SMOOTHING}"] = Prior(np.zeros(1), np.full(1, smoothing_std()))
        for h in self.hypotheses:
            for p in h.effect.parameters:
                out[h.key(p.name)] = Prior(p.centre, np.full(p.width, p.std))
        for name, value in (self.fixed or {}).items():
            out[name] = Prior(value, ALGEBRA.held * out[name].std)
        return out

    @cached_property
    def stamps(self) -> dict[str, Array]:
        """The stamps (n,) s of every group of measurements."""
        recording = self.recording
        out = {f"{i.name}.{part}": i.time for i in recording.imus for part in ("gyro", "accel")}
        for encoder in recording.encoders:
            out["encoder.angle"] = encoder.time
        for i, pose in enumerate(recording.poses):
            out |= {f"pose{i + 1}.position": pose.time, f"pose{i + 1}.rotation": pose.time}
        return out

    @cached_property
    def slopes(self) -> dict[str, dict[str, Array]]:
        """The measured velocities and rates (n, 3) of poses whose errors last."""
        return {name: slopes(self.poses[name]) for name in self.wander}

    @cached_property
    def poses(self) -> dict[str, Pose]:
        """The measured poses as their rows are named, in their order."""
        return {f"pose{i + 1}": pose for i, pose in enumerate(self.recording.poses)}

    @cached_property
    def bends(self) -> dict[str, tuple[Array, Array]]:
        """How fast the rates of the segments of smoothed poses change, rad/s^2, and that in turn (n, 3)."""
        return {name: self._bends(self.poses[name]) for name in self.smoothed}

    def _bends(self, pose: Pose) -> tuple[Array, Array]:
        imu = next(i for i in self.recording.imus if self.recording.carrier(i.name) == pose.segment)
        change = slope_of(imu.gyro, imu.rate)
        bends = (x @ self.mounts[imu.name].turn.T for x in (change, slope_of(change, imu.rate)))
        first, second = (np.stack([np.interp(pose.time, imu.time, x) for x in b.T], axis=1) for b in bends)
        return first, second

    @property
    def parameters(self) -> Parameters:
        """Their places in one vector."""
        return Parameters({name: len(prior.start) for name, prior in self.priors.items()})

    def values(self, h: Hypothesis, state: State) -> Values:
        """Return an effect's parameters as jets."""
        out = {}
        for p in h.effect.parameters:
            jet = variable((h.key(p.name), CONSTANT), state.values[h.key(p.name)])
            if p.log:
                grown = np.exp(np.clip(jet.value, -ALGEBRA.most_log_step, ALGEBRA.most_log_step))
                jet = jet.through(grown, grown)
            out[p.name] = jet
        return out

    def at(self, place: str) -> Iterator[Hypothesis]:
        """Yield the effects at a place."""
        return (h for h in self.hypotheses if h.at == place)

    def moment(self, state: State, stamps: Array, sensor: str) -> Moment:
        """Return the splines at a sensor's stamps (n,), its clock's error taken out."""
        time = Jet((stamps - self.start)[:, None])
        if sensor in self.offsets:
            time = time - variable((f"{sensor}.offset", CONSTANT), state.values[f"{sensor}.offset"])
        for h in self.at(sensor):
            time = h.effect.clock(time, self.values(h, state))
        return Moment(self.tracks, state.coefficients, time)

    def blind(self, h: Hypothesis, state: State) -> tuple[tuple[float, float], ...]:
        """Return when an effect acts as its law does not say, (from, to) s on the splines."""
        return h.effect.blind({p.name: state.values[h.key(p.name)] for p in h.effect.parameters})

    def course_std(self, h: Hypothesis, state: State) -> tuple[float, float]:
        """Return by how much an effect's sensor may be off its law in these windows, rad/s and m/s^2."""
        return h.effect.course_std({p.name: state.values[h.key(p.name)] for p in h.effect.parameters})

    def gravity(self, state: State) -> Jet:
        """Return the world's gravity (1, 3) m/s^2."""
        gravity = Jet(self.rig.gravity[None])
        for h in self.at("world"):
            gravity = h.effect.gravity(gravity, self.values(h, state))
        return gravity

    def scene(self, moment: Moment, segment: Motion) -> Scene:
        """Return what an effect may ask of the rig, but for what is its own."""
        time = moment.time
        if self.rig.hinge:
            angle, rate, accel = (moment.track(HINGE, order) for order in range(3))
            axis = np.eye(3)[[HINGE_AXIS]]
            return Scene(time, segment, angle, rate, accel, rate.at(axis.T), Jet(axis))
        if self.rig.ball and segment.turn is not None:
            return Scene(time, segment, *swing(segment), segment.rate, segment.turn.back(np.eye(3)[[SWING_AXIS]]))
        return Scene(time, segment)

    @staticmethod
    def own(scene: Scene, h: Hypothesis, moment: Moment, mount: Link | None = None) -> Scene:
        """Return the scene with an effect's own states in it, and the sensor on its segment."""
        return replace(scene, mount=mount, state=lambda name, order: moment.track(h.key(name), order))

    def carrier(self, state: State, moment: Moment, imu: str) -> Motion:
        """Return the motion of the segment that carries an IMU."""
        return self.segment(state, moment, self.recording.carrier(imu))

    def segment(self, state: State, moment: Moment, name: str) -> Motion:
        """Return the motion of one segment."""
        return self._chain(state, moment, name)[name]

    def segments(self, state: State, moment: Moment) -> Mapping[str, Motion]:
        """Return the motion of every segment."""
        return self._chain(state, moment, self.rig.tree.last.name)

    def last(self, state: State, moment: Moment) -> Motion:
        """Return the motion of the last segment, beyond the joint."""
        return self.segment(state, moment, self.rig.tree.last.name)

    def _chain(self, state: State, moment: Moment, to: str) -> Mapping[str, Motion]:
        """Return the motion of the segments up to one, each on what holds it; not to be written to: it is kept."""
        acting = tuple(h for h in self.hypotheses if h.at in ("joint", "world"))
        key = key_of((*self.rig.content, to), self.rig.widths, state, moment, acting)
        return KEPT.get(key, lambda: self._moved(state, moment, to)) if key else self._moved(state, moment, to)

    def _moved(self, state: State, moment: Moment, to: str) -> dict[str, Motion]:
        base = self.rig.first(moment, self.gravity(state))
        found: dict[str, Motion] = {}
        for segment in self.rig.tree.segments:
            held = base if segment.parent is None else found[segment.parent]
            if segment is self.rig.tree.last:
                held = held.child(self.joint_link(state, moment, held))
            elif segment.parent is not None:
                held = held.child(self.rig.joint(moment, segment))
            found[segment.name] = held
            if segment.name == to:
                break
        return found

    def joint_link(self, state: State, moment: Moment, first: Motion) -> Link:
        """Return the joint with what acts there: the last segment on what holds it, whose motion is `first`."""
        link = self.rig.joint(moment, self.rig.tree.last)
        scene = self.scene(moment, first)
        for h in self.at("joint"):
            link = h.effect.joint(link, self.own(scene, h, moment), self.values(h, state))
        return link

    def mount(self, imu: Imu, state: State, moment: Moment, segment: Motion) -> Link:
        """Return an IMU on its segment."""
        base = self.mounts[imu.name]
        turn = Turn(base.turn[None]) @ rotation(
            variable((f"{imu.name}.rotation", CONSTANT), state.values[f"{imu.name}.rotation"])
        )
        moved = variable((f"{imu.name}.translation", CONSTANT), state.values[f"{imu.name}.translation"])
        link = Link(turn, offset=moved + base.position)
        scene = self.scene(moment, segment)
        for h in self.at(imu.name):
            link = h.effect.mount(link, self.own(scene, h, moment, link), self.values(h, state))
        return link

    def reading(self, imu: Imu, state: State, moment: Moment, segment: Motion) -> Reading:
        """Return what an IMU would report."""
        segment = carrier(segment)
        link = self.mount(imu, state, moment, segment)
        sensor = segment.child(link)
        reading = Reading(sensor.rate, sensor.force, moment.time)
        scene = self.scene(moment, segment)
        for h in self.at(imu.name):
            reading = h.effect.filtered(reading, self.own(scene, h, moment, link), self.values(h, state))
        errors = [h.effect.error(reading, self.values(h, state)) for h in self.at(imu.name)]
        gyro = sum((e.gyro for e in errors if e.gyro is not None), reading.gyro)
        accel = sum((e.accel for e in errors if e.accel is not None), reading.accel)
        return Reading(chained(gyro, segment), chained(accel, segment), reading.time)

    def joint_angle(self, state: State, moment: Moment) -> Jet:
        """Return what an encoder of the hinge would report (n, 1) rad."""
        angle = moment.track(HINGE)
        if any(True for _ in self.at("joint")):
            scene = self.scene(moment, self.rig.first(moment, self.gravity(state)))
            for h in self.at("joint"):
                angle = h.effect.encoder(angle, self.own(scene, h, moment), self.values(h, state))
        if misreads(self.recording):
            angle = read(angle, variable((ERROR, CONSTANT), state.values[ERROR]))
        return angle

    def measured(self, state: State, alone: Collection[str] = ()) -> Iterator[Rows]:
        """Yield the rows of every sensor, or of some IMUs alone, in their own unit (std 1).

        None of a triple of which no sample counts, as of one that clips throughout.
        """
        yield from (rows for rows in self._all(state, alone) if rows.time.size)

    def _all(self, state: State, alone: Collection[str]) -> Iterator[Rows]:
        for imu in self.recording.imus:
            if alone and imu.name not in alone:
                continue
            moment = self.moment(state, imu.time, imu.name)
            segment = self.carrier(state, moment, imu.name)
            reading = self.reading(imu, state, moment, segment)
            place = moment.time.value[:, 0]
            for part, model, got in (("gyro", reading.gyro, imu.gyro), ("accel", reading.accel, imu.accel)):
                yield self._masked(f"{imu.name}.{part}", place, model - got)
        if alone:
            return
        for encoder in self.recording.encoders:
            moment = self.moment(state, encoder.time, "encoder")
            residual = self.joint_angle(state, moment) - (encoder.angle + encoder.zero)[:, None]
            yield self._masked("encoder.angle", moment.time.value[:, 0], residual)
        for name, pose in self.poses.items():
            yield from self._posed(state, name, pose)

    def _posed(self, state: State, name: str, pose: Pose) -> Iterator[Rows]:
        """Yield the rows of a measured pose; of samples that count nowhere, nothing is computed."""
        masks = [(self.masks or {}).get(f"{name}.{part}", np.ones(pose.time.size, bool)) for part in POSE_PARTS]
        asked = np.flatnonzero(masks[0] | masks[1])
        pose = taken(pose, asked)
        moment = self.moment(state, pose.time, name)
        segment = self.segment(state, moment, pose.segment)
        lasting = None
        if name in self.smoothed:
            window = variable((f"{name}.{SMOOTHING}", CONSTANT), state.values[f"{name}.{SMOOTHING}"])
            first, second = (b[asked] for b in self.bends[name])
            seen = {part: slope[asked] for part, slope in self.slopes.get(name, {}).items()}
            lasting = Lasting(self.wander.get(name), seen, window, (first, second))
        placed = partial(moment.track, POSITION) if POSITION in self.tracks.widths else None
        for part, residual, seen_at in pose_errors(pose, segment, placed, lasting):
            yield self._masked(f"{name}.{part}", moment.time.value[:, 0], residual, seen_at, asked)

    def _masked(
        self,
        name: str,
        time: Array,
        residual: Jet,
        measured: Array | None = None,
        asked: NDArray[np.intp] | None = None,
    ) -> Rows:
        every = slice(None) if asked is None else asked
        mask = np.ones(len(time), dtype=bool)
        if self.masks is not None and name in self.masks:
            mask = self.masks[name][every]
        if measured is not None:
            mask = mask & np.isfinite(measured).all(axis=1)
        std = np.ones(residual.value.shape[1])
        if self.louder is not None and name in self.louder:
            std = self.louder[name][every][mask, None] * std
        if not mask.all():
            time, residual = time[mask], _pick(residual, mask)
        return Rows(name, time, residual, std)


def taken(pose: Pose, asked: NDArray[np.intp]) -> Pose:
    """Return some samples (k,) of a pose."""
    position, quaternion = (None if x is None else x[asked] for x in (pose.position, pose.quaternion))
    return replace(pose, time=pose.time[asked], position=position, quaternion=quaternion)


def _pick(jet: Jet, mask: NDArray[np.bool_]) -> Jet:
    """Return the rows of a jet that count."""
    n = len(mask)
    blocks = {key: d[mask] if d.shape[0] == n else d for key, d in jet.blocks.items()}
    return Jet(jet.value[mask], blocks)


def started(model: Model, state: State) -> State:
    """Return the state with every parameter and spline of `model`, the missing ones at their start."""
    values = {name: state.values.get(name, prior.start.copy()) for name, prior in model.priors.items()}
    missing = model.tracks.width - state.coefficients.shape[1]
    extra = np.zeros((len(state.coefficients), missing))
    return State(np.concatenate([state.coefficients, extra], axis=1), values)


def middles(model: Model) -> Array:
    """Return the middles (n,) s of the intervals between knots."""
    knots = model.tracks.knots
    return np.asarray(knots.start + knots.step * (np.arange(knots.count - 5) + 0.5), dtype=float)


def inside(model: Model) -> Array:
    """Return the middles (n,) s of the intervals between the first and the last sample, as stamped.

    Only there a law is asked: before the first sample a damped spring's state grows backwards, and with a phase that
    every change of its frequency turns, so that steps would have to be short.
    """
    time, (first, last) = middles(model), sampled(model)
    return time[(time >= first) & (time <= last)]


def sampled(model: Model) -> tuple[float, float]:
    """Return when the first and the last sample are stamped, s on the splines."""
    stamps = model.stamps.values()
    return min(float(t[0]) for t in stamps) - model.start, max(float(t[-1]) for t in stamps) - model.start


__all__ = ["Model", "inside", "middles", "sampled", "started"]
