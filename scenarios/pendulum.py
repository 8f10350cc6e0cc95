"""Scenarios of the spherical pendulum (Garcia de Villa et al., section IV-A)."""

import numpy as np

from imubench.scenarios.scenario import Experiment, Scenario, declared_mounts
from imubench.sim.imu_model import Declared
from imubench.sim.motion import AngleMotion
from imubench.sim.play import play
from imubench.sim.rigs import Mount, pendulum, springs
from imubench.sim.signals import Sines

DURATION = 10.0  # s


def ellipse() -> AngleMotion:
    """Return the paper's motion: 17, 9 and 3 deg about x, y and z, periods 1, 1 and 1.5 s, on an ellipse."""
    x, y, z = np.deg2rad([17.0, 9.0, 3.0])
    return AngleMotion(
        tilt=Sines(x, 1.0),
        spin=Sines(y, 1.0, np.pi / 2),  # a quarter period behind: the limb goes round
        heading=Sines(z, 1 / 1.5),
    )


def rigid(rng: np.random.Generator) -> Experiment:
    """Play the paper's pendulum with a rigid mount."""
    rig = pendulum()
    return Experiment(rig, play(rig, ellipse(), DURATION), Declared(mounts=declared_mounts(rig, rng)))


def soft(rng: np.random.Generator) -> Experiment:
    """Play the paper's pendulum with the sensor on springs: 6 Hz along, 9 Hz about, damped by a fifth."""
    mount = Mount(position=pendulum().mounts[0].position, translation=springs(6.0, 0.2), rotation=springs(9.0, 0.2))
    rig = pendulum(mounts=(mount,))
    return Experiment(rig, play(rig, ellipse(), DURATION), Declared(mounts=declared_mounts(rig, rng)))


SCENARIOS = (
    Scenario("pendulum-ellipse", "a limb circles about its pivot, IMU fixed", None, "xsens_mtw_awinda", rigid),
    Scenario("pendulum-soft", "the same limb, its IMU on springs and dampers", None, "xsens_mtw_awinda", soft),
)
