"""One case: a recording in format 1 with effects concealed in it, and the truth about it, kept apart."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from imubench.proof.frames import Track, grid
from imubench.proof.free import free
from imubench.proof.hinge import hinge
from imubench.proof.instruments import read_encoder, read_pose, reference
from imubench.proof.mounts import Mount, declared, random_mount, sensor_track
from imubench.proof.options import RIGS, Effect, Options, World, find
from imubench.proof.pendulum import pendulum
from imubench.proof.ranges import drawn, twins
from imubench.proof.rotation import to_quaternion
from imubench.proof.sensors import Samples, noise_std, read_imu
from imubench.proof.unknown import NAMES as OUTSIDE
from imubench.proof.write import write_folder

DETAIL = ("kind", "peak")
NEARER = 0.85  # of its angle from hanging: where a stop that was not touched is tried next
Asked = Sequence[tuple[Any, ...]]
"""Effects as (name, at) or (name, at, parameters); parameters None: drawn."""


@dataclass(frozen=True)
class Case:
    """Everything about one case: what is asked, what moved, what the sensors read."""

    options: Options
    seed: int
    effects: list[Effect]
    world: World
    mounts: list[Mount]
    tracks: list[Track]  # of the sensing elements
    imus: list[Samples]

    @property
    def rates(self) -> list[float]:
        """The nominal rates in Hz."""
        return [self.options.rate, self.options.rate2 or self.options.rate][: len(self.imus)]


def make_case(
    out: Path, rig: str = "hinge", effects: Asked = (), seed: int = 0, strength: str = "medium", **options: Any
) -> dict[str, Any]:
    """Write a recording into the new folder `out` and return its truth.

    effects: (name, at) or (name, at, parameters) each; without parameters they are drawn by `seed` and `strength`
    (weak, medium, strong). options: the fields of `Options`. The same arguments give the same bytes.
    """
    case = build(rig, effects, seed, strength, **options)
    write(case, out)
    return truth(case)


def build(rig: str = "hinge", effects: Asked = (), seed: int = 0, strength: str = "medium", **options: Any) -> Case:
    """Return a case in memory; see `make_case`."""
    chosen = Options(rig=rig, **options)
    if rig not in RIGS:
        raise ValueError(f"unknown rig '{rig}'; known: {', '.join(RIGS)}")
    if chosen.swing and (rig == "free" or (rig == "hinge" and chosen.base != "fixed")):
        raise ValueError("a swing needs a pendulum, or a hinge with base='fixed'")
    found: list[Effect] = []
    for name, at, *rest in effects:
        given = rest[0] if rest and rest[0] is not None else None
        parameters = given if given is not None else drawn(name, at, chosen, seed, strength)
        found.append(Effect(name, at, parameters, name not in OUTSIDE))
    return played(chosen, settled(chosen, found, seed), seed)


def settled(options: Options, effects: list[Effect], seed: int) -> list[Effect]:
    """Return the effects with limits and angles that were drawn relative to the motion.

    `share` of the largest reading becomes the `limit` of a saturation; `from_rest` becomes the `angle` of a stop or
    the `q0` of a spring.
    """
    open_ones = [e for e in effects if {"share_of_peak", "from_rest"} & set(e.parameters)]
    if not open_ones:
        return effects
    rest = [e for e in effects if e not in open_ones]
    if all("from_rest" in e.parameters for e in open_ones):
        hangs, case = moved(options, rest, grid(options.seconds), seed).hangs, None
    else:
        case = played(options, rest, seed)
        hangs = case.world.hangs
    done = []
    for e in effects:
        p = dict(e.parameters)
        if case and "share_of_peak" in p:
            samples = case.imus[int(e.at[-1]) - 1]
            peak = max(float(np.abs(getattr(samples, channel)).max()) for channel in p["channels"])
            p = {"limit": p["share_of_peak"] * peak, "channels": p["channels"]}
        elif "from_rest" in p:
            off = p.pop("from_rest")
            if e.effect == "end_stop":  # the sign of its angle is its side: it must not be on the way to hanging
                off = off if off * (hangs + off) > 0 else -off
                p["angle"] = hangs + touched(options, rest, hangs, off, seed)
            else:
                p["q0"] = hangs + off
        done.append(replace(e, parameters=p))
    return done


def touched(options: Options, rest: list[Effect], hangs: float, off: float, seed: int) -> float:
    """Return how far (rad) from hanging a stop is: `off`, or as much nearer as the swing needs to touch it.

    A stop that nothing touches changes no sample, and nobody could find it. Its angle keeps its sign.
    """
    t = grid(options.seconds)
    nearer = off
    while nearer * (hangs + nearer) > 0 and abs(nearer) > 0.1 * abs(off):
        stop = Effect("end_stop", "joint", {"angle": hangs + nearer}, True)
        world = moved(options, [*rest, stop], t, seed)
        inside = np.any([(t >= a) & (t <= b) for a, b in world.swings], axis=0)
        if np.any((world.angle[0][inside] - hangs) * np.sign(off) > abs(nearer)):
            return nearer
        nearer *= NEARER
    return off


def played(options: Options, effects: list[Effect], seed: int) -> Case:
    """Return the case of effects whose parameters are all there."""
    t = grid(options.seconds)
    world = moved(options, effects, t, seed)
    mounts, tracks, imus = [], [], []
    for i, segment in enumerate(world.segments):
        at, rate = f"imu{i + 1}", (options.rate2 or options.rate) if i else options.rate
        mounts.append(random_mount(options, at, effects, seed))
        tracks.append(sensor_track(world, segment, mounts[-1], at, effects))
        imus.append(read_imu(tracks[-1], at, effects, options, rate, seed))
    return Case(options, seed, effects, world, mounts, tracks, imus)


def moved(options: Options, effects: list[Effect], t: np.ndarray, seed: int) -> World:
    """Return the motion of a rig on the grid t."""
    world = find(effects, "gravity")
    gravity = float(world["g"]) if world else options.gravity
    if options.rig == "hinge":
        return hinge(options, effects, t, gravity, seed)
    if options.rig == "pendulum":
        return pendulum(options, effects, t, gravity, seed)
    return free(options, t, gravity, seed)


def write(case: Case, out: Path) -> None:
    """Write the recording of a case; nothing in it tells its truth."""
    options, world = case.options, case.world
    top = {"format": 1, "name": options.name, "rig": options.rig, "motion": world.declared["motion"]}
    top |= {"gravity": options.gravity}
    top |= {key: world.declared[key] for key in ("base", "base_quaternion") if key in world.declared}
    tables: dict[str, list[dict[str, Any]]] = {"imu": []}
    for i, (samples, mount, rate) in enumerate(zip(case.imus, case.mounts, case.rates, strict=True)):
        entry: dict[str, Any] = {"name": f"imu{i + 1}", "file": f"imu{i + 1}.csv", "rate": rate}
        if options.declare_noise and options.noise:
            for channel in ("gyro", "accel"):
                usual = noise_std(channel, entry["name"], case.effects, options)[1]
                entry[f"{channel}_noise_std"] = float(f"{usual * (1 + options.misdeclared):.3g}")
        columns = {"time": samples.time}
        for prefix, values in (("gyr", samples.gyro), ("acc", samples.accel)):
            columns |= {f"{prefix}_{axis}": values[:, k] for k, axis in enumerate("xyz")}
        tables["imu"].append(entry | declared(options, mount) | {"columns": columns})
    if options.encoder:
        tables["encoder"] = [_filed("encoder.csv", "joint", read_encoder(world, case.effects, options, case.seed))]
    if options.pose if options.pose is not None else options.rig == "free":
        names = [f"segment{i + 1}" for i in range(len(world.segments))]
        poses = [read_pose(track, n, options, case.seed) for track, n in zip(world.segments, names, strict=True)]
        tables["pose"] = [_filed(f"pose{i + 1}.csv", "segment", pose) for i, pose in enumerate(poses)]
    if world.swings:
        tables["free_swing"] = [{"start": start, "end": end} for start, end in world.swings]
    if "body" in world.declared:
        tables["body"] = [dict(world.declared["body"])]
    if options.reference:
        tables["reference"] = [{"file": "reference.csv", "columns": reference(world, options)}]
    write_folder(out, top, tables)


def truth(case: Case) -> dict[str, Any]:
    """Return what is true of a case, as JSON can hold it."""
    return {
        "format": 1,
        "seed": case.seed,
        "rig": case.options.rig,
        "effects": [told(e) for e in case.effects],
        "equivalent": [told(e) for e in twins(case.effects, case.options)],
        "mounts": [
            {"position": plain(m.position), "quaternion": plain(to_quaternion(m.rotation))} for m in case.mounts
        ],
        "options": plain(asdict(case.options)),
    }


def told(effect: Effect) -> dict[str, Any]:
    """Return an effect as JSON can hold it; `detail` has what the table of effects does not name as a parameter."""
    parameters = dict(effect.parameters)
    detail = {key: parameters.pop(key) for key in DETAIL if key in parameters}
    return plain(asdict(replace(effect, parameters=parameters)) | {"detail": detail})


def plain(value: Any) -> Any:
    """Return a value with arrays as lists and NumPy's numbers as Python's."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, np.ndarray):
        return value.tolist()
    return value.item() if isinstance(value, np.generic) else value


def _filed(file: str, first: str, entry: dict[str, Any]) -> dict[str, Any]:
    return {first: entry[first], "file": file} | entry
