"""Laws of effects against their equations, integrated apart."""

import numpy as np
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from imubench.effects import EFFECTS
from imubench.effects.effect import Scene
from imubench.jets import Jet, Turn, rotation
from imubench.links import Link, Motion

GRAVITY = np.array([0.0, 0.0, -9.81])


def plain_scene(angle):
    """A scene without a single derivative: what a simulation hands over."""
    n = len(angle)
    still = Motion(Jet(np.zeros((n, 3))), Jet(np.zeros((n, 3))), Jet(np.tile([0, 0, 9.81], (n, 1))))
    zero = Jet(np.zeros((n, 1)))
    return Scene(Jet(np.arange(n)[:, None] * 0.01), still, Jet(angle[:, None]), zero, zero)


def test_axis_coupling_is_the_tables_product_of_rotations():
    q, c = np.linspace(-1.5, 1.5, 7), np.array([0.2, -0.3])
    hinge = Link(Turn(Rotation.from_euler("Y", q[:, None]).as_matrix()))
    got = EFFECTS["axis_coupling"].joint(hinge, plain_scene(q), {"coupling": Jet(c[None])})
    expected = Rotation.from_euler("YXZ", np.stack([q, c[0] * q, c[1] * q], axis=1))
    assert_allclose(got.turn.matrix, expected.as_matrix(), atol=1e-14)  # rounding
    assert got.turn.blocks == {}


def test_a_pivots_shaking_is_read_off_its_states():
    time = np.arange(0, 60, 0.01)
    rng = np.random.default_rng(1)
    tones = rng.uniform(2.0, 6.0, size=(60, 1))
    shaking = sum(np.sin(2 * np.pi * f * time + rng.uniform(0, 6, 3)[:, None]).T for f in tones)
    found = EFFECTS["moving_pivot"].read({}, {"acceleration": 0.4 * shaking / shaking.std()}, 0.01)
    assert_allclose(found["std"], 0.4, rtol=1e-6)  # its own definition
    assert_allclose(found["band"], [2.2, 5.8], atol=0.5)  # 5 % and 95 % of random tones


def turning(t):
    """A segment that tumbles: its attitude, rate, angular acceleration and origin's acceleration, by SciPy."""
    angles = np.array([0.5 * np.sin(4 * t), 0.4 * np.cos(3 * t + 1), 0.3 * np.sin(5 * t)])
    return Rotation.from_rotvec(angles), np.array([2 * np.sin(6 * t), np.cos(7 * t), 3 * np.sin(5 * t + 1)])


def body_rates(t, h=1e-4):
    r = [turning(t + k * h)[0] for k in (-1, 0, 1)]
    first, second = ((a.inv() * b).as_rotvec() / h for a, b in ((r[0], r[1]), (r[1], r[2])))
    half = (first + second) / 2
    return half, (second - first) / h


def segment_motion(times):
    rows = [(turning(t), body_rates(t)) for t in times]
    turn = Turn(np.stack([a[0].as_matrix() for a, _ in rows]))
    force = [a[0].inv().apply(a[1] - GRAVITY) for a, _ in rows]
    return Motion(*(Jet(np.array(x)) for x in ([b[0] for _, b in rows], [b[1] for _, b in rows], force)), turn)


def with_states(scene_time, segment, states, link):
    sensor = segment.child(link)
    return Scene(Jet(scene_time[:, None]), segment, state=lambda _, order: states[order], mount=link, sensor=sensor)


def test_a_soft_mount_obeys_newton():
    """x'' = R'(g - a) - w' x s - w x (w x s) - 2 w x x' - W^2 x - 2 Z W x', integrated apart."""
    place, f, zeta = np.array([0.1, 0.02, 0.03]), np.array([7.0, 9.0, 11.0]), 0.2
    w0 = 2 * np.pi * f

    def slope(t, y):
        (r, a), (w, wd) = turning(t), body_rates(t)
        x, v = y[:3], y[3:]
        s = place + x
        inertial = r.inv().apply([0, 0, -9.81] - a) - np.cross(wd, s) - np.cross(w, np.cross(w, s))
        return np.concatenate([v, inertial - 2 * np.cross(w, v) - w0**2 * x - 2 * zeta * w0 * v])

    times = np.linspace(0.2, 1.0, 9)
    y = solve_ivp(slope, (0, 1), np.zeros(6), t_eval=times, rtol=1e-9, atol=1e-12).y.T
    accel = np.array([slope(t, row)[3:] for t, row in zip(times, y, strict=True)])
    states = [Jet(y[:, :3]), Jet(y[:, 3:]), Jet(accel)]
    soft, p = EFFECTS["soft_mount"], {"frequency": Jet(f[None]), "damping_ratio": Jet(np.full((1, 1), zeta))}
    segment = segment_motion(times)
    nominal = Link(rotation(np.array([[0.4, -1.0, 0.3]])), offset=Jet(place[None]))
    link = soft.mount(nominal, with_states(times, segment, states, nominal), p)
    (law,) = soft.equations(with_states(times, segment, states, link), p)
    assert np.abs(y[:, :3]).max() > 2e-3
    assert_allclose(law.residual.value, 0.0, atol=1e-6)  # m/s^2; the integration's tolerance times W^2


def test_a_rocking_mount_obeys_the_torques_in_world_axes():
    """Angular momentum about the pivot, in world axes: k^2 W' = -R (w0^2 rho + 2 z w0 r) + R c x (g - a_pivot)."""
    nominal_turn, pivot = Rotation.from_rotvec([0.4, -1.0, 0.3]), np.array([0.1, 0.02, 0.03])
    com, lever = np.array([0.003, 0.001, -0.002]), np.array([0.0, 0.01, 0.02])
    f, zeta, k = np.array([6.0, 8.0, 10.0]), np.array([0.1, 0.15, 0.2]), 0.015
    w0 = 2 * np.pi * f

    def parts(t, y):
        (r, a), (w, wd) = turning(t), body_rates(t)
        sensor = Rotation.from_quat(y[:4])
        rho = ((r * nominal_turn).inv() * sensor).as_rotvec()
        relative = sensor.inv().apply(y[4:] - r.apply(w))
        at_pivot = a + r.apply(np.cross(wd, pivot) + np.cross(w, np.cross(w, pivot)))
        torque = sensor.apply(-(w0**2) * rho - 2 * zeta * w0 * relative)
        return r, sensor, rho, torque + np.cross(sensor.apply(com), [0, 0, -9.81] - at_pivot) / k**2

    def slope(t, y):
        _, sensor, _, accel = parts(t, y)
        x, yq, z, wq = sensor.as_quat()
        gx, gy, gz = y[4:] / 2  # q' = (0, W) q / 2, W in world axes
        change = [wq * gx + gy * z - gz * yq, wq * gy + gz * x - gx * z, wq * gz + gx * yq - gy * x,
                  -gx * x - gy * yq - gz * z]  # fmt: skip
        return np.concatenate([change, accel])

    times, h = np.linspace(0.2, 0.4, 5), 1e-4
    start = np.concatenate([(turning(0.0)[0] * nominal_turn).as_quat(), turning(0.0)[0].apply(body_rates(0.0)[0])])
    fine = np.sort(np.concatenate([times - h, times, times + h]))
    y = solve_ivp(slope, (0, 0.41), start, t_eval=fine, rtol=1e-10, atol=1e-11, method="DOP853").y.T
    rho = np.array([parts(t, row)[2] for t, row in zip(fine, y, strict=True)]).reshape(-1, 3, 3)
    states = [rho[:, 1], (rho[:, 2] - rho[:, 0]) / (2 * h), (rho[:, 2] - 2 * rho[:, 1] + rho[:, 0]) / h**2]
    rocking = EFFECTS["rocking_mount"]
    p = {n: Jet(v[None]) for n, v in (("frequency", f), ("damping_ratio", zeta), ("com", com), ("lever", lever))}
    segment = segment_motion(times)
    nominal = Link(rotation(np.array([[0.4, -1.0, 0.3]])), offset=Jet((pivot + nominal_turn.apply(lever))[None]))
    jets = [Jet(s) for s in states]
    link = rocking.mount(nominal, with_states(times, segment, jets, nominal), p)
    (law,) = rocking.equations(with_states(times, segment, jets, link), p)
    assert np.abs(rho).max() > 0.03
    size = np.abs(w0**2 * rho).max()
    assert_allclose(law.residual.value, 0.0, atol=2e-3 * size)  # a small turn's third power, differences' 1e-4
