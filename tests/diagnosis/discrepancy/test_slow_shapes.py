"""A jump, a walk, a drift and coloured noise of one sensor are told apart by their shape."""

import numpy as np
import pytest
from scipy.signal import lfilter

from imubench.diagnosis.discrepancy.drift_tests import SlowErrors, cosines_at
from imubench.diagnosis.discrepancy.terms import JUMP as JUMPS
from imubench.diagnosis.discrepancy.terms import Term
from imubench.diagnosis.solve.threads import one_thread

RATE, SAMPLES = 100.0, 1500
TIME = np.arange(SAMPLES) / RATE


def known(errors):
    """What white noise of power 1 leaves to know of errors (n, 3): every cosine has an information of n."""
    cosines = cosines_at(TIME / TIME[-1], 46)
    force = -(cosines.T @ errors).T.reshape(-1)
    return SlowErrors.told(cosines, float(TIME[-1]), float(TIME[1]), np.kron(np.eye(3), cosines.T @ cosines), force)


def noise(rng, share, corner=0.5):
    """White noise (n, 3) of power 1, with first-order noise of `share` of it beside."""
    keep = np.exp(-2 * np.pi * corner / RATE)
    drive = np.sqrt(share * (1 - keep**2)) * rng.standard_normal((5 * SAMPLES, 3))
    return (rng.standard_normal((5 * SAMPLES, 3)) + lfilter([1.0], [1.0, -keep], drive, axis=0))[-SAMPLES:]


def slow_error(kind, rng, size=1.0):
    if kind == "drift":
        return 0.1 * (TIME - 7.5)[:, None] * [1.0, -0.5, 0.2]
    if kind == "jump":
        return size * (TIME > 5.0)[:, None] * [0.1, 1.0, 0.1]
    steps = rng.standard_normal((SAMPLES, 3)) / np.sqrt(RATE)
    return (0.5 * size if kind == "walk" else 0.0) * np.cumsum(steps, axis=0)


@one_thread
def likeliest(kind, rng, share, size=1.0):
    slow = known(slow_error(kind, rng, size) + noise(rng, share))
    worth = {"walk": slow.walk(), "drift": slow.drift(), "jump": slow.jump(1.0 * (TIME > 5.0))}
    return {name: value - worth["drift"] for name, value in worth.items()}


@pytest.mark.parametrize("kind", ["jump", "walk"])
@pytest.mark.parametrize(("share", "size"), [(0.0, 1.0), (0.1, 2.5)])
def test_what_is_no_drift_is_likelier_than_one(kind, share, size):
    found = [likeliest(kind, np.random.default_rng(seed), share, size) for seed in range(12)]
    assert np.mean([max(f, key=f.get) == kind and f[kind] > 10 for f in found]) >= (0.9 if kind == "jump" else 0.8)


@pytest.mark.parametrize("kind", ["drift", "nothing"])
@pytest.mark.parametrize("share", [0.0, 0.1, 0.2])
def test_nothing_is_surely_likelier_than_a_drift_where_there_is_one_or_noise_alone(kind, share):
    found = [likeliest(kind, np.random.default_rng(seed), share) for seed in range(12)]
    assert max(max(f.values()) for f in found) < 10


WALK = Term("imu1", "accel", "time", TIME, {}, ())
JUMP = Term("imu1", "accel", JUMPS, TIME, {"accel": (TIME > 5.0)[:, None, None] * np.ones((1, 3, 1))}, (0,))


@one_thread
def beyond(kind, seed, share, size=1.0):
    rng = np.random.default_rng(seed)
    slow = known(slow_error(kind, rng, size) + noise(rng, share))
    return slow.beyond(WALK), slow.beyond(JUMP)


@pytest.mark.long
@pytest.mark.parametrize("share", [0.0, 0.2])
def test_a_walk_and_a_jump_are_worth_more_than_a_drift_or_nothing_and_noise_is_not(share):
    walks, jumps = zip(*(beyond("nothing", seed, share) for seed in range(12)), strict=True)
    assert max(*walks, *jumps) < 5
    assert max(max(beyond("drift", seed, share)) for seed in range(12)) < 10
    assert np.median([beyond("walk", seed, share, 2.5)[0] for seed in range(12)]) > 10
    assert np.median([beyond("jump", seed, share, 2.5)[1] for seed in range(12)]) > 10


@one_thread
def test_what_nothing_is_known_of_changes_nothing():
    cosines = cosines_at(TIME / TIME[-1], 46)
    seen = np.kron(np.diag([1.0, 1.0, 0.0]), cosines.T @ cosines)
    errors = slow_error("jump", None) + noise(np.random.default_rng(3), 0.0)
    force = -(cosines.T @ (errors * [1.0, 1.0, 0.0])).T.reshape(-1)
    blind = SlowErrors.told(cosines, float(TIME[-1]), float(TIME[1]), seen, force)
    assert blind.jump(1.0 * (TIME > 5.0)) - blind.drift() > 10
    assert len(blind.beside[0].pull) == 2 * 46
