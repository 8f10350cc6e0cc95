"""A hinge with play: its rotation, what is read off it, and its law against point masses on a moving frame."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from imubench.diagnosis.problem.motion_prior import heavy_tailed
from imubench.effects import VARIANTS
from imubench.effects.effect import Scene
from imubench.jets import Jet, Turn, variable
from imubench.links import Link, Motion

FALLS, WOBBLES, SPRUNG = (
    next(e for e in VARIANTS if (e.name, e.variant) == ("joint_play", variant)) for variant in ("", "wobbly", "springy")
)
DIRECTION = 0.7
E = np.array([np.cos(DIRECTION), 0.0, np.sin(DIRECTION)])


def scene_with(phi, segment=None, angle=None):
    """A scene without a derivative by anything; `phi` and `angle` are values, rates and accelerations (n, m)."""
    n = len(phi[0])
    still = Motion(Jet(np.zeros((n, 3))), Jet(np.zeros((n, 3))), Jet(np.zeros((n, 3))))
    turned = [None] * 3 if angle is None else [Jet(x) for x in angle]
    return Scene(Jet(np.zeros((n, 1))), segment or still, *turned, state=lambda _, order: Jet(phi[order]))


@pytest.mark.parametrize(
    ("effect", "off", "values"),
    [(WOBBLES, 0.03 * E[[0, 2]], {}), (FALLS, [0.03], {"direction": Jet(np.array([[DIRECTION]]))})],
)
def test_play_turns_about_an_axis_in_segment_2(effect, off, values):
    q = np.array([0.4, -1.0])
    phi = np.tile(off, (2, 1))
    hinge = Link(Turn(Rotation.from_euler("Y", q[:, None]).as_matrix()))
    got = effect.joint(hinge, scene_with([phi, 0 * phi, 0 * phi]), values)
    expected = Rotation.from_euler("Y", q[:, None]) * Rotation.from_rotvec(np.tile(0.03 * E, (2, 1)))
    assert_allclose(got.turn.matrix, expected.as_matrix(), atol=1e-14)  # rounding


def test_range_and_direction_are_read_off_the_states():
    rng = np.random.default_rng(0)
    side = 0.02 * np.sign(rng.normal(size=(4000, 1))) + 1e-4 * rng.normal(size=(4000, 1))
    both = side * E[[0, 2]] + 1e-4 * rng.normal(size=(4000, 2))
    found = WOBBLES.read({}, {"rotation": both}, 0.01)
    assert_allclose(found["direction"], DIRECTION, atol=0.01)
    for size in (found["range"], FALLS.read({}, {"rotation": side}, 0.01)["range"]):
        assert_allclose(size, 0.02, rtol=0.02)  # the spread of 1e-4 at its 99 % point


def test_springs_are_within_their_range_nearly_always():
    swung = 0.01 * np.sin(np.linspace(0.0, 400.0, 20000))[:, None]
    found = SPRUNG.read({}, {"rotation": swung}, 0.01)["range"]
    assert_allclose(found, 0.01 * np.sin(0.95 * np.pi / 2), rtol=1e-3)
    assert_allclose(SPRUNG.read_error({}, {"rotation": swung}, 0.01)["range"], 0.15 * found)


# masses in kg at points in m of segment 2: the same inertia about every axis through the joint, not about it balanced
MASSES = np.array([0.4, 0.4, 0.4, 0.4, 0.4, 0.4])
POINTS = np.array([[0.35, 0, 0], [-0.05, 0, 0], [0, 0.25, 0], [0, -0.25, 0], [0, 0, 0.25], [0, 0, -0.25]])


def test_springs_balance_the_torques_of_point_masses():
    """Their accelerations by differences of where they are, in a frame that moves and turns in all directions.

    To first order in the play: of 2e-4 rad, and of its rates, the second is 1e-3 of the first.
    """
    time, h = np.linspace(0.0, 2.0, 41), 1e-3
    g = np.array([0.0, 0.0, -9.81])
    size, pulse, frequency, damping = 2e-4, 9.0, 1.3, 0.2

    def hinge(t):
        return 0.7 * np.sin(2.1 * t + 0.3)

    def frame(t):
        return Rotation.from_euler("zyx", np.stack([0.8 * np.sin(1.3 * t), 0.5 * np.cos(1.7 * t), 0.9 * t], axis=1))

    def origin(t):
        return np.stack([0.3 * np.sin(2.0 * t), 0.2 * np.cos(3.1 * t), 0.1 * np.sin(4.0 * t)], axis=1)

    def swayed(t):
        return size * np.sin(pulse * t)

    def placed(t):
        """Every mass in the world (n, masses, 3)."""
        own = frame(t) * Rotation.from_euler("Y", hinge(t)[:, None]) * Rotation.from_rotvec(swayed(t)[:, None] * E)
        return origin(t)[:, None] + np.stack([own.apply(r) for r in POINTS], axis=1)

    assert_allclose(MASSES @ POINTS**2, (MASSES @ POINTS**2)[0])  # every axis
    before, now, after = (frame(time + s * h) for s in (-1, 0, 1))
    rates = [(a.inv() * b).as_rotvec() / h for a, b in ((before, now), (now, after))]
    force = (origin(time + h) - 2 * origin(time) + origin(time - h)) / h**2 - g
    segment = Motion(*(Jet(x) for x in ((rates[0] + rates[1]) / 2, (rates[1] - rates[0]) / h, now.inv().apply(force))))
    angle = [hinge(time), (hinge(time + h) - hinge(time - h)) / (2 * h)]
    angle += [(hinge(time + h) - 2 * hinge(time) + hinge(time - h)) / h**2]
    phi = [swayed(time), size * pulse * np.cos(pulse * time), -(pulse**2) * swayed(time)]
    scene = scene_with([x[:, None] for x in phi], segment, [x[:, None] for x in angle])

    inertia = float(MASSES @ np.sum(np.cross(E, POINTS) ** 2, axis=1))
    values = {
        "frequency": frequency, "damping_ratio": damping, "share": 1.0, "direction": DIRECTION,
        "arm": MASSES @ POINTS / inertia,
    }  # fmt: skip
    (law,) = SPRUNG.equations(scene, {name: Jet(np.atleast_2d(x)) for name, x in values.items()})

    acceleration = (placed(time + h) - 2 * placed(time) + placed(time - h)) / h**2
    own = now * Rotation.from_euler("Y", hinge(time)[:, None]) * Rotation.from_rotvec(swayed(time)[:, None] * E)
    load = np.stack([own.inv().apply(a) for a in np.moveaxis(acceleration - g, 1, 0)], axis=1)
    torque = np.einsum("k,nk->n", MASSES, np.sum(np.cross(E, POINTS) * load, axis=2)) / inertia
    w = 2 * np.pi * frequency
    springs = w**2 * phi[0] + 2 * damping * w * phi[1]
    assert_allclose(law.residual.value[:, 0], torque + springs, atol=1e-3 * np.abs(torque).max())
    assert np.abs(torque).max() > 5.0


def test_a_share_of_the_load_pushes_no_more_than_it():
    n = 4
    rng = np.random.default_rng(1)
    motion = Motion(*(Jet(rng.normal(size=(n, 3))) for _ in range(3)))
    angle, none = [rng.normal(size=(n, 1)) for _ in range(3)], [np.zeros((n, 1))] * 3
    values = {p.name: Jet(np.atleast_2d(np.exp(p.centre) if p.log else p.centre + 0.1)) for p in SPRUNG.parameters}
    pushed = [
        SPRUNG.equations(scene_with(none, motion, angle), values | {"share": Jet(np.array([[s]]))})[0].residual.value
        for s in (1.0, 0.25)
    ]
    assert_allclose(pushed[1], 0.25 * pushed[0])


def test_a_heavy_tailed_residual_costs_as_cauchys_errors_do():
    x, std = np.array([[-30.0, -0.7], [0.0, 1e-6], [0.4, 900.0]]), np.array([0.5, 2.0])
    got = heavy_tailed(variable("x", x), std)
    assert_allclose(0.5 * (got.value / std) ** 2, np.log1p((x / std) ** 2), rtol=1e-9, atol=1e-18)
    assert np.array_equal(np.sign(got.value), np.sign(x))
    ((_, slopes),) = got.blocks.items()
    small = 1e-6 * np.maximum(np.abs(x), 1.0)
    either = [heavy_tailed(Jet(x + s * small), std).value for s in (-1, 1)]
    finite = (either[1] - either[0]) / (2 * small)
    assert_allclose(np.stack([slopes[:, i, i] for i in (0, 1)], axis=1), finite, rtol=1e-4)
