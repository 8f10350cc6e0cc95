"""A motion that has an end is not played beyond it; one that rests or repeats is played for any time."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from imubench.dataset.motion_file import MotionFile
from imubench.errors import InputError
from imubench.scenarios.hinge import hand_motion
from imubench.scenarios.olsson2020.motions import MARGIN, MOTIONS
from imubench.sim import rigs
from imubench.sim.motion import AngleMotion, Carried
from imubench.sim.play import play
from imubench.sim.signals import STILL, Sines, hand

MINUTE = 60.0  # s
FINITE = {
    "hand": lambda rng: hand_motion(rng, MINUTE),
    "olsson2020, free": lambda rng: MOTIONS[7].motion(rng, MINUTE - 2 * MARGIN),
    "olsson2020, planar": lambda rng: MOTIONS[5].motion(rng, MINUTE - 2 * MARGIN),
    "file": lambda rng: MotionFile.parse(table_of(MINUTE), "m.csv").motion,
    "carried": lambda rng: Carried(hand_motion(rng, MINUTE), STILL, STILL, STILL),
    "of its own": lambda rng: partial(call, hand_motion(rng, MINUTE)),
}


def call(motion, time):
    return motion(time)


def table_of(seconds: float) -> bytes:
    time = np.linspace(0.0, seconds, 601)
    return "\n".join(["time,angle", *(f"{t},{np.sin(t)}" for t in time)]).encode()


@pytest.mark.parametrize("sprung", [False, True])
@pytest.mark.parametrize("name", FINITE)
def test_a_motion_is_not_played_for_longer_than_it_lasts(name, sprung):
    """A hand's motion played on beyond its end reached hinge angles of 1e9 rad, as polynomials do."""
    first, second = rigs.hinge().mounts
    rig = rigs.hinge(mounts=(replace(first, translation=rigs.springs(20.0, 0.2) if sprung else None), second))
    motion = FINITE[name](np.random.default_rng(1))
    truth = play(rig, motion, MINUTE, 50.0)
    assert np.abs(truth.joint_angle).max() < 10.0  # rad; a random angle has a std of 0.7 to 2
    with pytest.raises(InputError, match=r"play of 120 s: motion: expected at most 6\d(\.\d+)? s, got 119.98 s$"):
        play(rig, motion, 2 * MINUTE, 50.0)


def test_motions_that_rest_or_repeat_are_played_for_any_time():
    """A sequential motion comes to rest, and sines have no end."""
    rng = np.random.default_rng(1)
    for motion in (MOTIONS[3].motion(rng, 20.0), AngleMotion(angle=Sines(1.0, 0.5))):
        assert np.abs(play(rigs.hinge(), motion, 300.0, 50.0).joint_angle).max() < 20.0  # rad, several strokes


def test_a_signal_says_from_when_on_it_is_defined():
    with pytest.raises(InputError, match="motion: expected times from 0 s on, got -1 s"):
        hand(np.random.default_rng(1), 10.0, 1.0, 1.0)(np.array([-1.0, 0.0]))
