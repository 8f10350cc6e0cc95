"""Shared by all tests: independent rigid-body kinematics, random motions, real recordings."""

import os
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from imubench.arrays import Array
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.problem.fit import Fit
from imubench.format1 import read
from imubench.proof.case import make_case
from imubench.recording import Body, Encoder, Recording
from imubench.sim.motion import AngleMotion
from imubench.sim.signals import hand
from tests.command import own_signals
from tests.damage import whole

Jet = tuple[Array, Array, Array]  # a function of time with its first and second derivative


def product(a: Jet, b: Jet) -> Jet:
    """Multiply matrices that depend on time, by the product rule."""
    return a[0] @ b[0], a[1] @ b[0] + a[0] @ b[1], a[2] @ b[0] + 2 * a[1] @ b[1] + a[0] @ b[2]


def turn(axis: str, angle: Jet) -> Jet:
    """Rotation matrices (n, 3, 3) about a coordinate axis, by the chain rule."""
    i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    n = len(angle[0])
    c, s = np.cos(angle[0]), np.sin(angle[0])
    R, dR, ddR = np.tile(np.eye(3), (n, 1, 1)), np.zeros((n, 3, 3)), np.zeros((n, 3, 3))
    for matrix, cosine, sine in ((R, c, s), (dR, -s, c), (ddR, -c, -s)):
        matrix[:, i, i] = matrix[:, j, j] = cosine
        matrix[:, i, j], matrix[:, j, i] = -sine, sine
    first, second = angle[1][:, None, None], angle[2][:, None, None]
    return R, dR * first, ddR * first**2 + dR * second


class JetRig:
    """Poses, rates and accelerations of an AngleMotion's segments, from matrices and the product rule alone."""

    def __init__(self, motion: AngleMotion, time: Array) -> None:
        self.R1 = product(
            product(turn("z", motion.heading(time)), turn("x", motion.tilt(time))), turn("y", motion.spin(time))
        )
        self.R2 = product(self.R1, turn("y", motion.angle(time)))
        x, y, z = motion.x(time), motion.y(time), motion.z(time)
        self.p = tuple(np.stack([x[k], y[k], z[k]], axis=-1) for k in range(3))

    def imu(self, segment: int, position: Array, R_bs: Array, gravity: float = 9.81) -> tuple[Array, Array, Array]:
        """Return world position, rate and specific force in sensor axes of a rigid mount."""
        R, dR, ddR = self.R1 if segment == 1 else self.R2
        where = self.p[0] + R @ position
        acceleration = self.p[2] + ddR @ position
        force = np.einsum("nji,nj->ni", R @ R_bs, acceleration + np.array([0.0, 0.0, gravity]))
        spin = np.swapaxes(R, 1, 2) @ dR
        rate = np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], axis=-1) @ R_bs
        return where, rate, force


@pytest.fixture(autouse=True)
def signals_as_before() -> Iterator[None]:
    """A test that calls `main` leaves Ctrl-C to those after it, and to the processes that they start."""
    with own_signals():
        yield


@pytest.fixture
def jets() -> type[JetRig]:
    return JetRig


@pytest.fixture
def good(tmp_path: Path) -> Path:
    """A recording with everything in it, which each test breaks in one place."""
    return whole(tmp_path / "rec")


@pytest.fixture
def random_motion() -> Callable[[int, float], AngleMotion]:
    def make(seed: int, duration: float = 10.0) -> AngleMotion:
        rng = np.random.default_rng(seed)
        stds = {"heading": 1.0, "tilt": 0.5, "spin": 1.0, "angle": 0.8, "x": 0.1, "y": 0.1, "z": 0.1}
        return AngleMotion(**{name: hand(rng, duration, std, 1.5) for name, std in stds.items()})

    return make


@pytest.fixture(scope="session")
def hardly_counting(tmp_path_factory) -> Callable[[int], Fit]:
    """Return the fit of a clean hinge of whose second accelerometer only the first so many samples count, made once."""
    folder = tmp_path_factory.mktemp("hinge") / "r"
    make_case(folder, "hinge", [], 5, seconds=3.0)
    recording = read(folder)[0]

    @cache
    def fit(count: int) -> Fit:
        return nominal_fit(recording, {"imu2.accel": np.arange(recording.imus[1].time.size) < count})

    return fit


@pytest.fixture(scope="session")
def recordings() -> Path:
    """The folder of real recordings; the test is skipped without it."""
    folder = os.environ.get("IMUBENCH_DATA")
    if not folder or not Path(folder).is_dir():
        pytest.skip("real recordings: set IMUBENCH_DATA to their folder")
    return Path(folder)


@pytest.fixture(scope="session")
def swung():
    """Return a function that makes a light arm's free swing on a fixed base, seen by an encoder of 500 Hz alone.

    The equation of motion is integrated apart, dry friction as a steep smooth step. `laws` holds sizes by effect, `off`
    what the encoder says beside the angle.
    """
    body = Body(mass=1.0, com=[0.0, 0.0, -0.115], inertia=[4.4e-3, 4.4e-3, 4.4e-6])
    inertia, pull = 4.4e-3 + 0.115**2, 9.81 * 0.115

    def made(
        laws: dict[str, float],
        seconds: float = 9.0,
        noise: float = 4e-5,
        off: Callable[[Array], Array | float] = lambda q: 0.0,
        seed: int = 0,
    ) -> Recording:
        c, t, d = (laws.get(name, 0.0) for name in ("viscous_friction", "dry_friction", "air_drag"))

        def slope(_: float, y: Array) -> list[float]:
            q, w = y
            return [w, -(pull * np.sin(q) + c * w + t * np.tanh(w / 1e-3) + d * abs(w) * w) / inertia]

        time = np.arange(0.0, seconds, 2e-3)
        angle = solve_ivp(slope, (0, seconds), [1.6, 0.0], t_eval=time, rtol=1e-8, atol=1e-10, max_step=0.01).y[0]
        read = angle + off(angle) + noise * np.random.default_rng(seed).normal(size=time.size)
        return Recording(
            *("swung", "hinge"), encoders=(Encoder("hinge", time, read),), base="fixed", body=body, motion="free",
            base_quaternion=[1.0, 0.0, 0.0, 0.0], free_swings=((0.0, float(time[-1])),),
        )  # fmt: skip

    return made
