"""Streaming estimators hold no more after ten times as many samples: the arrays in their state are counted."""

from collections import deque
from dataclasses import fields, is_dataclass

import numpy as np
import pytest

from benchmarks.pendulum_runs import NOISE, circling
from imubench.estimators import sliding_splines
from imubench.estimators.arve import Arve
from imubench.estimators.arve_d import ArveD
from imubench.estimators.frick_rahmatalla import FrickRahmatalla
from imubench.estimators.gravity import GravityUkf
from imubench.estimators.guarded import GuardedPlugAndPlay
from imubench.estimators.mrvs import WindowMrvs
from imubench.estimators.plug_and_play import PlugAndPlay, Settings
from imubench.estimators.selection_online import OnlineSelection
from imubench.estimators.sliding import SlidingStream
from imubench.estimators.sliding_ekf import SlidingBank
from imubench.estimators.sliding_stream import Window
from imubench.estimators.two_imu_centre import TwoImuCentre
from imubench.paired import Paired


def held(thing, seen=None):
    """Bytes of the arrays that an object holds, whatever it holds them in, and 8 for each number in a container."""
    seen = set() if seen is None else seen
    if id(thing) in seen:
        return 0
    seen.add(id(thing))
    if isinstance(thing, np.ndarray):
        # a view keeps the whole array alive that it is a view of
        return held(thing.base, seen) if isinstance(thing.base, np.ndarray) else thing.nbytes
    if isinstance(thing, dict):
        return sum(held(x, seen) for x in thing.values())
    if isinstance(thing, (list, tuple, deque, set)):
        return 8 * len(thing) + sum(held(x, seen) for x in thing)
    if is_dataclass(thing) and not isinstance(thing, type):
        names = {f.name for f in fields(thing)} | set(getattr(thing, "__dict__", ()))
        return sum(held(getattr(thing, name), seen) for name in names)
    if type(thing).__module__.startswith(("imubench", "scipy")) and hasattr(thing, "__dict__"):
        return held(vars(thing), seen)
    return 0


def test_what_is_held_is_counted_through_containers_views_and_objects():
    whole = np.zeros(100)
    window = Window(1.0)
    before = held(window)
    assert held({"a": [whole[:3], whole[5:]]}) == 800 + 16  # both are views of one array; two places in a list
    for k in range(2000):
        window.add(0.001 * k, np.ones(3), np.ones(3), np.ones(3))
    assert held(window) > 2 * before  # a second of samples is more than it had room for at first


def by_sample(estimator, take):
    """Push samples of one IMU, cut from ten seconds of the paper's pendulum again and again."""
    runs = circling(np.random.default_rng(0), noise=NOISE)
    period = 600  # samples; 6 s, a whole number of the motion's periods

    def push(first, last):
        for k in range(first, last):
            i = k % period
            take(estimator, runs.gyro[0, i], runs.accel[0, i], runs.acceleration[0, i], 0.01 * k)

    return push


def by_second(estimator):
    rng = np.random.default_rng(0)

    def push(first, last):
        for k in range(first, last, 50):
            gyro1, gyro2, accel1, accel2 = rng.normal(size=(4, 50, 3))
            if isinstance(estimator, OnlineSelection):
                estimator.update(gyro1, gyro2, accel1, accel2)
            else:
                estimator.update(Paired(np.arange(k, k + 50) / 50, gyro1, accel1, gyro2, accel2))

    return push


def two_imus(estimator):
    runs = circling(np.random.default_rng(0), noise=NOISE)

    def push(first, last):
        for k in range(first, last):
            i = k % 600
            estimator.update(runs.gyro[[0, 0], i], runs.accel[[0, 0], i], 0.01)

    return push


def sliding_stream():
    stream = SlidingStream(*NOISE)
    return stream, by_sample(stream, lambda s, w, f, a, t: s.update(w, f, a, 0.01))


CASES = {
    "sliding-stream": (sliding_stream, 1600),  # twice its window
    "gravity-ukf": (lambda: (x := GravityUkf(), by_sample(x, lambda s, w, f, a, t: s.update(w, f, 0.01))), 300),
    "arve": (lambda: (x := Arve(), by_sample(x, lambda s, w, f, a, t: s.update(w, a, 0.01))), 300),
    "arve-d": (lambda: (x := ArveD(), by_sample(x, lambda s, w, f, a, t: s.update(w, a, 0.01))), 300),
    "mrvs-window": (lambda: (x := WindowMrvs(), by_sample(x, lambda s, w, f, a, t: s.update(w, a, t))), 300),
    "frick-rahmatalla": (
        lambda: (x := FrickRahmatalla(np.zeros(3)), by_sample(x, lambda s, w, f, a, t: s.update(w, a, 0.01))),
        300,
    ),
    "sliding filter bank": (
        lambda: (x := SlidingBank(), by_sample(x, lambda s, w, f, a, t: s.update(w, a, 0.01))),
        150,
    ),
    "plug-and-play": (lambda: (x := PlugAndPlay(Settings(n_max=100)), by_second(x)), 1000),
    "guarded": (lambda: (x := GuardedPlugAndPlay(Settings(n_max=100)), by_second(x)), 1000),
    "online selection": (lambda: (x := OnlineSelection(100), by_second(x)), 1000),
    "two-imu-centre": (lambda: (x := TwoImuCentre(), two_imus(x)), 300),
}


@pytest.mark.parametrize("name", list(CASES))
def test_the_state_is_as_large_after_ten_times_as_many_samples(name):
    make, samples = CASES[name]
    estimator, push = make()
    push(0, samples)
    early = held(estimator)
    push(samples, 10 * samples)
    assert early > 100  # something was found to count
    # Windows of 800 or of 801 samples, as stamps are rounded, and how many slow samples a selection has: 2 %.
    assert held(estimator) <= 1.02 * early


def test_what_windows_of_a_stream_share_is_bounded_too():
    assert sliding_splines.splines.cache_info().maxsize <= 4
    assert sliding_splines._kept.cache_info().maxsize <= 32
    long = sliding_splines.MOST + 1
    before = sliding_splines._kept.cache_info().misses
    sliding_splines.Basis.even(long, 0.01, 50)  # the splines of a long record are not kept
    assert sliding_splines._kept.cache_info().misses == before
