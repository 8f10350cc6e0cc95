"""How large the physics outside the table is drawn, and where it may sit."""

import numpy as np

from imubench.proof.body import Body
from imubench.proof.options import Options
from imubench.proof.rotation import Parameters

UNKNOWN: dict[str, tuple[float, float, float]] = {
    "bias_jump": (3.0, 10.0, 40.0),  # times the noise std
    "thermal_walk": (1.0, 3.0, 10.0),  # times the noise std, after the whole recording
    "hysteresis": (0.02, 0.06, 0.2),  # share
    "cubic": (0.004, 0.02, 0.08),  # of the reading at 10 rad/s or 20 m/s^2
    "rectification": (0.002, 0.008, 0.03),  # m/s^2 per (m/s^2)^2
    "cross_talk": (0.01, 0.03, 0.1),  # share
    "dead_band": (0.01, 0.03, 0.1),  # rad/s
    "creep": (0.02, 0.06, 0.2),  # rad
    "hardening_mount": (20.0, 12.0, 8.0),  # Hz
    "cogging": (0.02, 0.06, 0.2),  # over m g l
    "wind": (0.01, 0.04, 0.15),  # over m g l
}


def moving_imus(options: Options) -> tuple[str, ...]:
    """Return the IMUs of a rig, but for one on a clamped segment, which nothing moves."""
    names = tuple(f"imu{i + 1}" for i in range(options.shape.imus))
    return names[1:] if options.clamped else names


def unknown_places(options: Options) -> dict[str, tuple[str, ...]]:
    """Return where the physics outside the table may sit on a rig with these options."""
    at_joint = ("cogging", "wind") if options.swing else ()
    found = dict.fromkeys([name for name in UNKNOWN if name not in ("cogging", "wind")], moving_imus(options))
    return found | dict.fromkeys(at_joint, ("joint",))


def draw_unknown(name: str, rng: np.random.Generator, level: int, options: Options, body: Body) -> Parameters:
    """Return random parameters, within +- 30 % of the level's size."""
    size = UNKNOWN[name][level] * float(rng.uniform(0.75, 1.3))
    channel = str(rng.choice(["gyro", "accel"]))
    noise = options.gyro_noise if channel == "gyro" else options.accel_noise
    direction = rng.standard_normal(3)
    direction /= np.linalg.norm(direction)
    weight = body.mass * options.gravity * float(np.linalg.norm(body.com))
    i, j = (int(k) for k in rng.permutation(3)[:2])
    typical = 10.0 if channel == "gyro" else 20.0
    width = (0.3 if channel == "gyro" else 1.0) * float(rng.uniform(0.5, 1.5))
    when = float(rng.uniform(0.25, 0.75) * options.seconds)
    choices: dict[str, Parameters] = {
        "bias_jump": {"channel": channel, "jump": size * noise * direction, "time": when},
        "thermal_walk": {"channel": channel, "density": size * noise / np.sqrt(options.seconds)},
        "hysteresis": {"channel": channel, "share": size, "width": width},
        "cubic": {"channel": channel, "factor": size / typical**2},
        "rectification": {"factor": size * direction},
        "cross_talk": {"from": i, "to": j, "share": size, "delay": float(rng.uniform(0.02, 0.06))},
        "dead_band": {"channel": "gyro", "width": size},
        "creep": {"rotation": size * direction, "time_constant": float(rng.uniform(0.1, 0.4) * options.seconds)},
        "hardening_mount": {
            "frequency": size,
            "damping_ratio": float(rng.uniform(0.05, 0.25)),
            "span": float(rng.uniform(0.5, 1.5) * 9.81 / (2 * np.pi * size) ** 2),
        },
        "cogging": {"torque": size * weight, "cogs": float(rng.integers(4, 13))},
        "wind": {"std": size * weight, "band": float(rng.uniform(0.5, 2.0))},
    }
    return choices[name]
