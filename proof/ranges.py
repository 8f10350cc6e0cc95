"""How large an effect is drawn: weak, medium, strong, each within +- 30 %, and where it may sit.

Weak is what careful work leaves behind and only a long recording shows; medium is an everyday fault; strong is one
that anybody would see in the plots. Secondary parameters (damping, directions, times) are drawn alike for all three.
"""

from collections.abc import Callable
from itertools import chain

import numpy as np

from imubench.proof.body import Body, limb
from imubench.proof.mounts import Mount, random_mount
from imubench.proof.options import Effect, Options, stream
from imubench.proof.rigs import SHAPES
from imubench.proof.rotation import Array, Parameters
from imubench.proof.unknown_ranges import UNKNOWN, draw_unknown, moving_imus

STRENGTHS = ("weak", "medium", "strong")
SIZES: dict[str, tuple[float, float, float]] = {
    "gyro_bias": (0.002, 0.01, 0.05),  # rad/s: a warm sensor, a day later, never calibrated
    "accel_bias": (0.02, 0.08, 0.3),  # m/s^2: 2, 8, 30 mg
    "gyro_drift": (1e-4, 4e-4, 2e-3),  # rad/s per s: 6 mrad/s to 0.1 rad/s in a minute
    "accel_drift": (5e-4, 3e-3, 1e-2),  # m/s^2 per s
    "gyro_scale": (0.004, 0.015, 0.05),  # 0.4 % to 5 %
    "accel_scale": (0.004, 0.015, 0.05),
    "gyro_misalignment": (0.005, 0.015, 0.05),  # rad
    "accel_misalignment": (0.005, 0.015, 0.05),
    "g_sensitivity": (3e-4, 1e-3, 4e-3),  # rad/s per m/s^2: datasheets say 1e-4 to 2e-3
    "gyro_noise": (1.5, 2.5, 5.0),  # times the declared std
    "accel_noise": (1.5, 2.5, 5.0),
    "low_pass": (35.0, 18.0, 8.0),  # Hz, cutoff
    "time_offset": (0.001, 0.006, 0.03),  # s: a tenth of a sample to three
    "clock_skew": (3e-5, 2e-4, 1e-3),  # 2 to 60 ms over a minute
    "saturation": (0.9, 0.7, 0.45),  # limit over the largest reading
    "quantisation": (5.0, 15.0, 50.0),  # step over the noise std
    "dropouts": (0.03, 0.1, 0.25),  # share of the samples
    "vibration": (0.05, 0.3, 1.5),  # m/s^2: a fan, a motor on the bench, a motor on the segment
    "impacts": (12.0, 40.0, 100.0),  # m/s^2 at the peak
    "mount_pose": (0.1, 0.25, 0.6),  # rad; the translation is a fifth of it in m
    "mount_shift": (0.01, 0.04, 0.15),  # rad; the translation is a fifth of it in m
    "soft_mount": (28.0, 15.0, 8.0),  # Hz: a stiff strap, a loose strap, foam
    "rocking_mount": (28.0, 15.0, 9.0),  # Hz
    "skin_sliding": (0.002, 0.008, 0.03),  # m/rad; the twist is five times it in rad/rad
    "joint_play": (0.006, 0.02, 0.06),  # rad
    "axis_coupling": (0.006, 0.02, 0.08),  # rad/rad
    "moving_centre": (0.002, 0.008, 0.03),  # m/rad: a knee rolls about 5 mm/rad
    "moving_pivot": (0.05, 0.3, 1.2),  # m/s^2
    "viscous_friction": (0.02, 0.08, 0.4),  # 1/s, c over the inertia
    "dry_friction": (0.005, 0.02, 0.08),  # t over m g l
    "air_drag": (0.01, 0.05, 0.25),  # 1/rad, d over the inertia
    "joint_spring": (0.03, 0.12, 0.5),  # k over m g l
    "end_stop": (0.9, 0.7, 0.45),  # rad from hanging; swings reach 0.5 to 1.5
    "backlash": (0.003, 0.01, 0.04),  # rad
    "inertia": (0.03, 0.1, 0.3),  # scale - 1
    "gravity": (0.02, 0.06, 0.2),  # m/s^2: the span over the Earth is 0.05
}
TORQUES = ("viscous_friction", "dry_friction", "air_drag", "joint_spring", "end_stop")
IN_THE_RIG = {*chain(*(shape.effects for shape in SHAPES.values())), *TORQUES, "backlash", "inertia", "gravity"}
IMU_EFFECTS = tuple(name for name in SIZES if name not in IN_THE_RIG)


def places(options: Options) -> dict[str, tuple[str, ...]]:
    """Return where every effect may sit on a rig with these options, for those that can be there at all."""
    found: dict[str, tuple[str, ...]] = dict.fromkeys(IMU_EFFECTS, moving_imus(options))
    shape = options.shape
    if not shape.hinge or options.clamped or options.pose:
        found["gravity"] = ("world",)  # otherwise an acceleration of the hand explains it
    if not shape.jointed:
        del found["skin_sliding"]  # there is no joint
    if shape.ball:
        del found["time_offset"], found["clock_skew"]  # there is no other clock
    joints = () if options.swing and shape.hinge else shape.effects
    found |= dict.fromkeys(joints, ("joint",))
    if options.swing:
        found |= dict.fromkeys(TORQUES, ("joint",)) | {"inertia": ("body",)}
    if options.encoder and shape.hinge:
        found["backlash"] = ("joint",)
    return found


def drawn(name: str, at: str, options: Options, seed: int, strength: str) -> Parameters:
    """Return random parameters of an effect; raises ValueError for an unknown name or strength."""
    if strength not in STRENGTHS:
        raise ValueError(f"unknown strength '{strength}'; known: {', '.join(STRENGTHS)}")
    rng, level = stream(seed, f"draw {name} {at}"), STRENGTHS.index(strength)
    if name in UNKNOWN:
        return draw_unknown(name, rng, level, options, _body(options, seed))
    if name not in SIZES:
        raise ValueError(f"unknown effect '{name}'; known: {', '.join([*SIZES, *UNKNOWN])}")
    size = SIZES[name][level] * float(rng.uniform(0.75, 1.3))
    if name in IMU_EFFECTS:
        parameters = _SENSOR.get(name, _MOUNT.get(name, _plain))(name, size, rng, options)
        return seen(parameters, random_mount(options, at, [], seed), options)
    return _joint(name, size, rng, options, _body(options, seed))


def seen(parameters: Parameters, mount: Mount, options: Options) -> Parameters:
    """Return the parameters of a mount without the turn that no recording of the rig could show.

    With neither encoder nor measured pose, a turn of the sensor about the hinge axis is another zero of the hinge
    angle and another place; on a pendulum that goes for every turn, and in a free swing for that about the limb.
    """
    key = next((key for key in ("rotation", "twist") if key in parameters), None)
    if key is None or not options.shape.jointed or options.encoder or options.pose:
        return parameters
    if options.shape.ball and not options.swing:
        return parameters | {key: np.zeros(3)}
    axis = mount.declared_rotation[options.shape.turns_about]  # a row: the segment's axis in sensor axes
    turn = np.asarray(parameters[key])
    return parameters | {key: turn - axis * (axis @ turn)}


def _body(options: Options, seed: int) -> Body:
    return limb(stream(seed, "body"), axis=options.shape.along)


def _vector(rng: np.random.Generator, size: float) -> Array:
    v = rng.standard_normal(3)
    return np.asarray(size * v / np.linalg.norm(v))


def _plain(name: str, size: float, rng: np.random.Generator, options: Options) -> Parameters:
    key = name.split("_")[1]
    if key == "misalignment":
        return {"matrix": size * rng.uniform(0.4, 1.0, 6) * rng.choice([-1, 1], 6)}
    if name == "g_sensitivity":
        return {"matrix": size * rng.uniform(0.4, 1.0, (3, 3)) * rng.choice([-1, 1], (3, 3))}
    if key == "noise":
        return {"std": size * (options.gyro_noise if name.startswith("gyro") else options.accel_noise)}
    if name in ("time_offset", "clock_skew"):
        return {name.split("_")[1]: size * float(rng.choice([-1, 1]))}
    return {"rate" if key == "drift" else key: _vector(rng, size)}


def _digital(name: str, size: float, rng: np.random.Generator, options: Options) -> Parameters:
    channel = str(rng.choice(["gyro", "accel"]))
    if name == "low_pass":
        both = rng.random() < 0.6
        return {"cutoff": size, "channels": ["gyro", "accel"] if both else [channel]}
    if name == "saturation":  # `limit` follows once the motion is known
        return {"share_of_peak": min(size, 0.95), "channels": [channel]}
    if name == "quantisation":
        return {
            "step": size * (options.gyro_noise if channel == "gyro" else options.accel_noise),
            "channels": [channel],
        }
    if name == "dropouts":
        return {"fraction": size, "mode": str(rng.choice(["held", "missing"]))}
    if name == "vibration":
        return {"frequency": float(rng.uniform(0.13, 0.43) * options.rate), "amplitude": _vector(rng, size)}
    times = np.sort(rng.uniform(0.05, 0.95, rng.integers(3, 9)) * options.seconds)
    return {"times": times, "peak": size}


def _mount(name: str, size: float, rng: np.random.Generator, options: Options) -> Parameters:
    if name in ("mount_pose", "mount_shift"):
        when = {"time": float(rng.uniform(0.3, 0.7) * options.seconds)} if name == "mount_shift" else {}
        return when | {"rotation": _vector(rng, size), "translation": _vector(rng, size / 5)}
    if name == "skin_sliding":
        return {"slide": _vector(rng, size), "twist": _vector(rng, 5 * size)}
    three = size * rng.uniform(0.85, 1.25, 3)
    if name == "soft_mount":
        return {"frequency": three, "damping_ratio": float(rng.uniform(0.04, 0.3))}
    return {
        "frequency": three,
        "damping_ratio": rng.uniform(0.05, 0.3, 3),
        "com": _vector(rng, rng.uniform(0.0, 0.006)),
        "gyration": 0.015,
        "lever": _vector(rng, rng.uniform(0.0, 0.025)),
    }


_SENSOR: dict[str, Callable[[str, float, np.random.Generator, Options], Parameters]] = dict.fromkeys(
    ("low_pass", "saturation", "quantisation", "dropouts", "vibration", "impacts"), _digital
)
_MOUNT = dict.fromkeys(("mount_pose", "mount_shift", "soft_mount", "rocking_mount", "skin_sliding"), _mount)


def _joint(name: str, size: float, rng: np.random.Generator, options: Options, body: Body) -> Parameters:
    """Return the parameters of what sits at the joint, the body or the world."""
    weight = body.mass * options.gravity * float(np.linalg.norm(body.com))  # m g l
    side = float(rng.choice([-1, 1]))
    scaled = {"viscous_friction": ("c", body.about_y), "air_drag": ("d", body.about_y), "dry_friction": ("t", weight)}
    if name in scaled:
        key, unit = scaled[name]
        return {key: size * unit}
    if name == "joint_spring":
        return {"k": size * weight, "from_rest": float(rng.uniform(-0.5, 0.5))}
    if name == "joint_play":
        kind = str(rng.choice(["free", "springy"]))
        return {"range": size, "direction": float(rng.uniform(-np.pi, np.pi)), "kind": kind}
    if name == "axis_coupling":
        return {"coupling": size * rng.uniform(0.4, 1.0, 2) * rng.choice([-1, 1], 2)}
    if name == "moving_pivot":
        low = float(rng.uniform(0.2, 2.0))
        return {"std": size, "band": [low, low + float(rng.uniform(1.0, 8.0))]}
    if name == "moving_centre":
        slide = _vector(rng, size)
        return {"slide": slide}
    return {
        "end_stop": {"from_rest": side * size},
        "backlash": {"range": size},
        "inertia": {"scale": 1 + side * size},
        "gravity": {"g": options.gravity + side * size},
    }[name]


def twins(effects: list[Effect], options: Options) -> list[Effect]:
    """Return what the interface calls always equivalent to an effect of the case, with its parameters.

    `axis_coupling` and the gravity of a motion by hand name their twin without exact parameters (first order).
    """
    found = []
    for e in effects:
        p, hinge = e.parameters, options.shape.hinge and not options.clamped
        if e.effect in ("time_offset", "clock_skew") and options.shape.imus > 1:
            other = "imu2" if e.at == "imu1" else "imu1"
            found.append(Effect(e.effect, other, {key: -value for key, value in p.items()}))
        elif e.effect == "moving_centre" and hinge:
            found.append(Effect("skin_sliding", "imu1", {"slide": -np.asarray(p["slide"]), "twist": np.zeros(3)}))
        elif e.effect == "skin_sliding" and hinge and e.at == "imu1" and not np.any(p.get("twist", 0.0)):
            found.append(Effect("moving_centre", "joint", {"slide": -np.asarray(p["slide"])}))
        elif e.effect == "axis_coupling":
            found.append(Effect("skin_sliding", "imu2", {}))
        elif e.effect == "skin_sliding" and e.at == "imu2":
            found.append(Effect("axis_coupling", "joint", {}))
        elif e.effect == "gravity" and not options.swing:
            found += [
                Effect("accel_scale", f"imu{i + 1}", {"scale": np.full(3, p["g"] / options.gravity - 1)})
                for i in range(options.shape.imus)
            ]
    return found
