"""Joint centres that accelerate as in walking: the paper's pendulum, a hip, a knee, a hinge in the hand.

Garcia de Villa et al. take the joint centre to be at rest. Here it moves along world x (forward), y (to the side) and z
(up) in harmonics of the stride; docs/moving-pivot.md says where the figures come from.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from imubench import rotations
from imubench.errors import InputError, unknown
from imubench.recording import positive
from imubench.scenarios.hinge import hand_motion
from imubench.scenarios.pendulum import R_TEXT, ellipse, limb
from imubench.scenarios.scenario import Experiment, Scenario, declared_mounts, prescribed
from imubench.sim.imu_model import Declared
from imubench.sim.injected import Injected, injected_rig
from imubench.sim.motion import AngleMotion
from imubench.sim.play import play
from imubench.sim.rigs import Mount, Rig, free, hinge, random_hinge
from imubench.sim.signals import Sines
from imubench.truth import Truth

STRIDE = 0.95  # Hz, two steps; with each seed 0.9 to 1.0
DURATION = 20.0  # s

Joint = Literal["hip", "knee"]
HARMONICS: dict[Joint, tuple[tuple[tuple[int, float], ...], ...]] = {  # of the stride, and m, along x, y, z
    "hip": (((1, 0.005), (2, 0.010), (4, 0.002)), ((1, 0.020), (3, 0.004)), ((2, 0.022), (4, 0.003))),
    "knee": (((1, 0.150), (2, 0.030), (4, 0.003)), ((1, 0.020), (3, 0.006)), ((2, 0.030), (4, 0.004))),
}
BALL = "ball.xml"  # what `shared_centre` calls its rig: format 1 has no name for two segments on a ball joint
PELVIS_MOUNT = np.array([-0.10, 0.08, 0.08])  # m, from the hip to the sacrum


def gait(rng: np.random.Generator, joint: Joint = "hip", scale: float = 1.0) -> dict[str, Sines]:
    """Return the signals x, y, z in m of a joint centre in walking, times `scale`; rate and phases by `rng`."""
    if joint not in HARMONICS:
        raise unknown("joint", joint, HARMONICS)
    positive(scale, "scale", or_zero=True)
    stride = STRIDE + rng.uniform(-0.05, 0.05)
    signals = {}
    for axis, harmonics in zip("xyz", HARMONICS[joint], strict=True):
        orders, sizes = np.array(harmonics).T
        signals[axis] = Sines(scale * sizes, stride * orders, rng.uniform(0, 2 * np.pi, size=sizes.size))
    return signals


def moving(motion: AngleMotion, centre: dict[str, Sines]) -> AngleMotion:
    """Return a motion whose joint centre moves as `centre` says."""
    return replace(motion, **centre)


def pendulum_truth(
    motion: AngleMotion, duration: float = DURATION, rate: float = 1000.0, rig: Rig | None = None
) -> tuple[Rig, Truth]:
    """Play a limb, the paper's if none is given, about a pivot that moves with `motion`.

    The pendulum's pivot is fixed in its model. A free body whose origin is the pivot moves in the same way.
    """
    rig = limb() if rig is None else rig
    body = free(mounts=rig.mounts, segments=rig.segments, gravity=rig.gravity)
    truth = play(body, motion, duration, rate)
    return rig, replace(truth, rig="pendulum")


def shared_centre(
    motions: tuple[AngleMotion, AngleMotion],
    mounts: tuple[Mount, Mount],
    centre: dict[str, Sines],
    duration: float = DURATION,
    rate: float = 1000.0,
) -> Truth:
    """Play two segments on a ball joint: each as a free body whose origin, the joint centre, both have in common.

    The truth's rig is `BALL`, which is no file: such a recording can be estimated from, but not written.
    """
    one, two = (
        play(free(mounts=(mount,)), moving(motion, centre), duration, rate)
        for motion, mount in zip(motions, mounts, strict=True)
    )
    segment, sensor = replace(two.segments[0], name="segment2"), replace(two.sensors[0], name="imu2")
    return replace(one, rig=BALL, segments=(one.segments[0], segment), sensors=(one.sensors[0], sensor))


def hip_mounts(rng: np.random.Generator) -> tuple[Mount, Mount]:
    """Return a sensor on the sacrum, turned at random, and the paper's on the thigh."""
    return Mount(PELVIS_MOUNT, rotations.random(rng)), Mount(-R_TEXT)


def pelvis(stride: float = STRIDE, scale: float = 1.0) -> AngleMotion:
    """Return how a pelvis turns in walking: 4 deg of heading and of obliquity, 2 deg of tilt."""
    four, two = scale * np.deg2rad([4.0, 2.0])
    return AngleMotion(heading=Sines(four, stride), tilt=Sines(four, stride, 0.8), spin=Sines(two, 2 * stride, 0.3))


def thigh(stride: float = STRIDE) -> AngleMotion:
    """Return how a thigh turns in walking, as the pendulum's limb: flexion about y, 5 deg about the others."""
    five = np.deg2rad(5.0)
    return AngleMotion(heading=Sines(five, stride, 1.0), tilt=Sines(five, stride, 2.2), spin=_flexion(stride))


def _flexion(stride: float, offset: float = 0.0) -> Sines:
    return Sines(np.deg2rad([20.0, 4.0]), stride * np.array([1, 2]), np.array([0.0, 0.6]), offset)


def knee(stride: float = STRIDE, across: float = 1.0) -> AngleMotion:
    """Return how thigh and knee turn in walking; `across` scales what leaves the plane of flexion, 5 deg each."""
    five = across * np.deg2rad(5.0)
    bend = Sines(np.deg2rad([25.0, 14.0]), stride * np.array([1, 2]), np.array([2.0, 1.0]), offset=np.deg2rad(30.0))
    upright = _flexion(stride, offset=np.pi / 2)  # segment 1 extends along -x, the thigh upwards
    return AngleMotion(heading=Sines(five, stride, 1.0), tilt=Sines(five, stride, 2.2), spin=upright, angle=bend)


def knee_rig(rng: np.random.Generator) -> Rig:
    """Return a hinge with sensors on a thigh and a shank, 20 and 15 cm from the knee, turned at random."""
    places = (np.array([-0.20, 0.03, 0.06]), np.array([0.15, -0.02, 0.04]))
    one, two = (Mount(place, rotations.random(rng)) for place in places)
    return hinge(mounts=(one, two))


def circling(rng: np.random.Generator, seconds: float, effects: Sequence[Injected]) -> Experiment:
    """Play the paper's pendulum with its pivot moving as a hip."""
    if any(e["effect"] == "moving_pivot" for e in effects):
        raise InputError("pendulum-gait: expected another effect than moving_pivot; its pivot moves as it is")
    motion, nominal = moving(ellipse(), gait(rng)), limb()
    mounts = declared_mounts(nominal, rng)
    rig, truth = pendulum_truth(motion, seconds, rig=injected_rig(nominal, mounts, effects))
    return Experiment(rig, truth, Declared(mounts=mounts, gravity=nominal.gravity))


def by_hand(rng: np.random.Generator, seconds: float, effects: Sequence[Injected]) -> Experiment:
    """Play a random hinge turned by a hand while its joint centre moves as a knee."""
    rig = random_hinge(rng)
    motion = hand_motion(rng, seconds)
    return prescribed(rig, moving(motion, gait(rng, "knee")), seconds, rng, effects)


def walking(rng: np.random.Generator, seconds: float, effects: Sequence[Injected]) -> Experiment:
    """Play a knee in walking."""
    rig = knee_rig(rng)
    return prescribed(rig, moving(knee(), gait(rng, "knee")), seconds, rng, effects)


IMU = "xsens_mtw_awinda"
SCENARIOS = (
    Scenario(
        "pendulum-gait",
        "a limb circles about a pivot that moves as a hip in walking",
        "arve-d",
        IMU,
        circling,
        "pendulum",
        DURATION,
    ),
    Scenario(
        "hinge-gait",
        "a hinge turned by a hand, its centre moving as a knee's",
        "two-imu-centre",
        IMU,
        by_hand,
        seconds=DURATION,
    ),
    Scenario(
        "hinge-walking",
        "a knee in walking, near a plane, two IMUs",
        "two-imu-centre",
        IMU,
        walking,
        seconds=DURATION,
    ),
)
