"""Scenarios of the hinge rig."""

from collections.abc import Sequence

import numpy as np

from imubench import rotations
from imubench.arrays import Array
from imubench.recording import Body, Encoder
from imubench.scenarios.scenario import Experiment, Scenario, declared_mounts, prescribed
from imubench.sim.imu_model import Declared
from imubench.sim.injected import Injected, believed, injected_rig
from imubench.sim.motion import AngleMotion
from imubench.sim.rigs import Mount, Rig, hinge, random_hinge, springs
from imubench.sim.signals import STILL, Signal, hand
from imubench.sim.swing import Start, swing

DURATION = 60.0  # s
BANDWIDTH = 1.0  # Hz, of a hand that moves at ease


def hand_motion(rng: np.random.Generator, duration: float = DURATION, angle: Signal | None = None) -> AngleMotion:
    """Return a free motion of segment 1 with a bending hinge; `angle` replaces the random hinge angle."""
    return AngleMotion(
        heading=hand(rng, duration, 0.8, BANDWIDTH),
        tilt=hand(rng, duration, 0.4, BANDWIDTH),
        spin=hand(rng, duration, 0.8, BANDWIDTH),
        angle=hand(rng, duration, 0.7, BANDWIDTH, offset=0.6) if angle is None else angle,
        x=hand(rng, duration, 0.1, BANDWIDTH),
        y=hand(rng, duration, 0.1, BANDWIDTH),
        z=hand(rng, duration, 0.05, BANDWIDTH, offset=1.0),
    )


def moved_by_hand(rng: np.random.Generator, seconds: float, effects: Sequence[Injected]) -> Experiment:
    """Play a random hinge rig, both segments turning freely."""
    rig = random_hinge(rng)
    return prescribed(rig, hand_motion(rng, seconds), seconds, rng, effects)


def planar(rng: np.random.Generator, seconds: float, effects: Sequence[Injected]) -> Experiment:
    """Play a random hinge rig whose axis stays horizontal and still while both segments turn about it."""
    rig = random_hinge(rng)
    motion = AngleMotion(spin=hand(rng, seconds, 0.8, BANDWIDTH), angle=hand(rng, seconds, 0.7, BANDWIDTH, offset=0.6))
    return prescribed(rig, motion, seconds, rng, effects)


def locked(rng: np.random.Generator, seconds: float, effects: Sequence[Injected]) -> Experiment:
    """Play a random hinge rig whose joint a screw holds: its axis cannot be seen."""
    angle = float(rng.uniform(-0.5, 1.0))
    rig = random_hinge(rng, locked_at=angle)
    return prescribed(rig, hand_motion(rng, seconds, angle=STILL), seconds, rng, effects)


def soft(rng: np.random.Generator, seconds: float, effects: Sequence[Injected]) -> Experiment:
    """Play a hinge rig whose IMUs rock on foam, about 10 and 14 Hz, damped by a tenth."""
    mounts = tuple(
        Mount(
            position=np.array([side * 0.1, 0.0, 0.03]),
            quaternion=rotations.random(rng),
            rotation=springs([10.0, 14.0, 14.0], 0.1),
            com=np.array([0.0, 0.0, 0.002]),
            lever=np.array([0.0, 0.0, 0.02]),
        )
        for side in (-1.0, 1.0)
    )
    return prescribed(hinge(mounts=mounts), hand_motion(rng, seconds), seconds, rng, effects)


def swinging(rng: np.random.Generator, seconds: float, effects: Sequence[Injected]) -> Experiment:
    """Let segment 2 swing down from about 1 rad on a fixed base, with an encoder and some friction."""
    rig = hinge(
        base="fixed",
        base_quaternion=rotations.from_axis_angle(np.array([0.0, 1.0, 0.0]), np.pi / 2),
        damping=2e-4,
        dry_friction=5e-4,
    )
    start = Start(angle=float(rng.uniform(0.8, 1.2)))
    noise, count = 5e-4, len(range(0, round(seconds * 1000), 10))  # rad; an encoder of 100 Hz in a truth of 1000 Hz
    misread = rng.normal(scale=noise, size=count)
    mounts = declared_mounts(rig, rng)
    truth = swing(injected_rig(rig, mounts, effects), start, duration=seconds)
    assert truth.joint_angle is not None
    encoder = Encoder("hinge", truth.time[::10], truth.joint_angle[::10] + misread, noise)
    declared = Declared(
        mounts=mounts,
        gravity=rig.gravity,
        motion="free",
        base="fixed",
        base_quaternion=rig.base_quaternion,
        encoders=(encoder,),
        free_swings=((0.0, seconds),),
        body=believed(swinging_body(rig), effects),
    )
    return Experiment(rig, truth, declared)


def swinging_body(rig: Rig) -> Body:
    """Return mass, com and inertia of segment 2 together with its IMU."""
    segment, mount = rig.segments[1], rig.mounts[1]
    mass = segment.mass + mount.mass
    com = (segment.mass * segment.com + mount.mass * mount.position) / mass
    inertia = segment.inertia + mount.mass * mount.gyration**2
    inertia = inertia + segment.mass * _offset(segment.com - com) + mount.mass * _offset(mount.position - com)
    return Body(mass, com, inertia)


def _offset(d: Array) -> Array:
    return d @ d - d**2  # parallel axes, diagonal only


SCENARIOS = (
    Scenario("hinge-hand", "a hinge moved freely by a hand, random geometry", "olsson2020", "xsens_mtw", moved_by_hand),
    Scenario("hinge-planar", "both segments turn about a still, horizontal axis", "olsson2020", "xsens_mtw", planar),
    Scenario("hinge-locked", "a screw locks the joint: nothing to identify", "olsson2020", "xsens_mtw", locked),
    Scenario("hinge-soft", "the IMUs rock on foam at 10 and 14 Hz", "olsson2020", "xsens_mtw", soft),
    Scenario(
        "hinge-swing",
        "segment 2 swings free on a fixed base, with encoder",
        "olsson2020",
        "xsens_mtw",
        swinging,
        seconds=30.0,
        swings=True,
    ),
)
