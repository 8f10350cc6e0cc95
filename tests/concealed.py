"""Effects concealed by the independent generator, put into a model with their true numbers, and played by MuJoCo."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from imubench import rotations
from imubench.correction.export import write_model
from imubench.correction.read_model import Model, read_model
from imubench.correction.replay import truth_of_motion
from imubench.correction.sensor_chain import angle_read, read_by
from imubench.diagnosis.evidence import Evidence, FittedEffect, Level, Played, Pose, Trace
from imubench.diagnosis.result import Diagnosis, Finding, FitQuality, Interval, Parameter
from imubench.effects import EFFECTS
from imubench.format1 import read
from imubench.proof.case import build
from imubench.proof.filed import write
from imubench.proof.frames import LEAD, STEP
from imubench.proof.played import Case
from imubench.proof.rotation import to_quaternion
from imubench.proof.unknown import play as slack
from imubench.recording import Imu, Recording
from imubench.sim.swing import Start, swing
from imubench.truth import Truth

ROW = 5e-3  # s between two rows of a told motion: quintics through a hand's 4 Hz are right to 1e-6
SECONDS = 10.0
FINE, BALL = 2e-4, 5e-4  # s, of a roll-out: a step in which dry friction turns over, or a stop is met, is of order 1
SETTLED = 1.0  # s
GAIN = Interval(100.0, (90.0, 110.0))


@dataclass(frozen=True)
class Concealed:
    """A case of the generator, its recording, and a model's folder with the truth in it."""

    case: Case
    recording: Recording
    folder: Path

    def model(self) -> Model:
        return read_model(self.folder)

    def truth(self) -> Truth:
        model = self.model()
        rate = max(s.rate for s in (*model.imus.values(), *model.encoders.values()))
        return truth_of_motion(model.rig, model.motion, model.start, model.end - model.start, rate)


def concealed(
    folder: Path, rig: str, effects, told=None, variant: str = "", seed: int = 5, strength: str = "strong", **options
) -> Concealed:
    """A case with `effects`, and a model with `told` of them in it, all of them where nothing is said."""
    options = {"seconds": SECONDS, "geometry_error": False, "rest": 0.0} | options
    case = build(rig, effects, seed, strength, **options)
    write(case, folder / "recording")
    recording, _ = read(folder / "recording")
    known = [e for e in case.effects if told is None or e.effect in told]
    found = [finding(e.effect, e.at, e.parameters) for e in known]
    diagnosis = Diagnosis(
        recording.name, rig, "explained" if found else "no mismatch", (4.0, 1.0), (), tuple(found), (),
        FitQuality((4.0, 1.0)), "", 1.0,
    )  # fmt: skip
    (folder / "model").mkdir()
    write_model(diagnosis, evidence(case, recording, known, variant), folder / "model")
    return Concealed(case, recording, folder / "model")


def finding(name: str, at: str, parameters) -> Finding:
    """A finding with the numbers that the table of effects has."""
    law = EFFECTS[name]
    units = {p.name: p.unit for p in (*law.parameters, *law.found)}
    numbers = {key: value for key, value in parameters.items() if key in units}
    channels = parameters.get("channels", [])
    if name in ("saturation", "quantisation"):
        units = dict.fromkeys(units, "rad/s" if channels == ["gyro"] else "m/s^2")
    told = {
        key: Parameter(np.asarray(v, dtype=float), 0 * np.asarray(v, dtype=float), units[key])
        for key, v in numbers.items()
    }
    return Finding(name, at, 0.9, told, GAIN)


def evidence(case: Case, recording: Recording, known, variant: str) -> Evidence:
    """What a fit would tell that knows the truth."""
    fitted = tuple(
        FittedEffect(
            e.effect,
            e.at,
            variant,
            {"channels": tuple(e.parameters["channels"])} if "channels" in e.parameters else {},
            {k: np.asarray(v, dtype=float) for k, v in e.parameters.items() if k not in ("channels", "mode", "kind")},
        )
        for e in known
    )
    mounts = {f"imu{i + 1}": Pose(np.array(m.position), to_quaternion(m.rotation)) for i, m in enumerate(case.mounts)}
    imus = recording.imus
    noise = {f"{i.name}.{part}": getattr(i, f"{part}_noise_std") for i in imus for part in ("gyro", "accel")}
    if recording.encoders:
        noise["encoder.angle"] = recording.encoders[0].angle_noise_std
    levels = tuple(Level(group, "1", std, max(std, 1e-12), max(std, 1e-12)) for group, std in noise.items())
    still = np.zeros((imus[0].time.size, 3))
    trace = Trace(imus[0].name, "gyro", ("gyr_x", "gyr_y", "gyr_z"), "rad/s", imus[0].time, still, 1.0)
    return Evidence(recording, (trace,), motion(case, fitted), mounts, levels)


def motion(case: Case, fitted=()) -> Played:
    """The true motion as a fit would tell it, from 0.5 s before the recording to 0.4 s after it."""
    world, every = case.world, round(ROW / STEP)
    rows = slice(round((LEAD - 0.5) / STEP), len(world.t) - round(0.2 / STEP), every)
    first = world.segments[0]
    q = to_quaternion(np.broadcast_to(first.R, (len(world.t), 3, 3)))[rows]
    flips = np.where(np.sum(q[1:] * q[:-1], axis=1) < 0, -1.0, 1.0)
    q = q * np.cumprod(np.concatenate([[1.0], flips]))[:, None]
    hinge = case.options.rig == "hinge"
    still = (case.options.rig == "pendulum" and not any(e.effect == "moving_pivot" for e in case.effects)) or (
        hinge and case.options.base == "fixed"
    )
    placed = case.options.pose or (case.options.pose is None and case.options.rig == "free")
    force = None if still or placed else first.f[rows]
    place = first.p[rows] if placed else np.zeros((len(q), 3))
    angle = world.angle[0][rows] if hinge else None
    told = {"joint_play": {"rotation": play_of(case)[rows]}} if hinge else {}
    for f in (f for f in fitted if f.effect == "backlash"):
        told["backlash"] = {"gap": (world.angle[0] - slack(world.angle[0], float(f.values["range"])))[rows, None]}
    fitted = tuple(replace(f, time=world.t[rows], signals=told.get(f.effect, {})) for f in fitted)
    return Played(world.t[rows], q, place, angle, force, fitted)


def play_of(case: Case):
    """How segment 2 is turned beside the hinge's angle, (n, 2) rad about its x and z: exp(play) = Ry(q)' R1' R2."""
    first, second = (track.R for track in case.world.segments)
    q = case.world.angle[0]
    zero, one = 0 * q, 1 + 0 * q
    back = np.array([[np.cos(q), zero, -np.sin(q)], [zero, one, zero], [np.sin(q), zero, np.cos(q)]]).transpose(2, 0, 1)
    relative = back @ np.swapaxes(np.broadcast_to(first, second.shape), 1, 2) @ second
    return rotations.log(to_quaternion(relative))[:, [0, 2]]


def left(found: Concealed, name: str = "") -> dict[str, float]:
    """RMS of measured minus played over the noise by triple, nothing of chance being played; of one IMU, if named."""
    model, truth = found.model(), found.truth()
    out = {}
    for imu in found.recording.imus:
        if name in ("", imu.name):
            _, gyro, accel = read_by(truth, model.start, imu.time, imu.name, model.chain(imu.name))
            own = counted(found, imu)
            out[f"{imu.name}.gyro"] = rms(((imu.gyro - gyro) / imu.gyro_noise_std)[own])
            out[f"{imu.name}.accel"] = rms(((imu.accel - accel) / imu.accel_noise_std)[own])
    for encoder in found.recording.encoders:
        read_ = angle_read(truth, model.start, encoder.time, model.effects)
        out["encoder"] = rms((encoder.angle + encoder.zero - read_) / encoder.angle_noise_std)
    return out


def rolled(found: Concealed, seconds: float) -> tuple[np.ndarray, np.ndarray, Truth]:
    """An IMU's rates (n, 3) in a free swing, those of a roll-out by forces alone, and the truth of that.

    From the true state at the window's start; the sensors weigh nothing, for the declared body is with them.
    """
    model, world = found.model(), found.case.world
    start, _ = found.recording.free_swings[0]
    row = int(np.ceil((start + LEAD) / STEP))
    zero = float(world.t[row])
    segment = world.segments[-1]
    if found.case.options.rig == "hinge":
        state = Start(angle=float(world.angle[0][row]), angle_rate=float(world.angle[1][row]))
    else:
        state = Start(quaternion=to_quaternion(segment.R[row]), rate=segment.w[row])
    light = tuple(replace(m, mass=1e-9) for m in model.rig.mounts)
    step = FINE if model.rig.family == "hinge" else BALL
    truth = swing(replace(model.rig, mounts=light), state, seconds + 0.05, 500.0, step=step)
    imu = found.recording.imus[-1]
    own = (imu.time > zero) & (imu.time < zero + seconds)
    _, gyro, _ = read_by(truth, zero, imu.time[own], imu.name, model.chain(imu.name))
    return imu.gyro[own], gyro, truth


def counted(found: Concealed, imu: Imu):
    """The samples (n,) that are told: not the first, nor those while a mount slips.

    What springs and filters did before the first sample nobody tells, and of a slip the course is not in the table.
    """
    own = imu.time > imu.time[0] + SETTLED
    for e in found.case.effects:
        if e.effect == "mount_shift":
            own &= np.abs(imu.time - float(e.parameters["time"]) - 0.1) > 0.15
    return own


def rms(x) -> float:
    return float(np.sqrt(np.mean(np.asarray(x) ** 2)))


__all__ = ["Concealed", "concealed", "left", "rms", "rolled"]
