"""A rig is a tree: what is read from an MJCF file, and what can be asked of it."""

import mujoco
import numpy as np
import pytest

from imubench.effects import EFFECTS
from imubench.models import RIG_FILES, RIG_SUMMARIES, imu_names
from imubench.models.tree import BALL, FREE, HINGE, UNREAD, Tree, rig_tree, tree_of
from imubench.recording import Imu, Recording
from imubench.sim.rigs import hinge, standard_rig

CHAIN = """
<mujoco>
  <default><default class="turns"><joint type="ball"/></default></default>
  <worldbody>
    <body name="foot">
      <freejoint name="root"/>
      <geom type="capsule" fromto="0 0 0 0 0 -0.2" size="0.02"/>
      <body name="plate" pos="0 0 0.1" euler="0 0 90">
        <geom type="box" size="0.1 0.1 0.01"/>
        <site name="on_plate" pos="0.2 0 0"/>
      </body>
      <body name="shank">
        <joint name="ankle" class="turns"/>
        <geom type="capsule" fromto="0 0 0.02 0 0 0.4" size="0.03"/>
        <body name="worn" pos="0 0.05 0.2">
          <joint name="worn_x" type="slide"/><geom type="box" size="0.02 0.01 0.03"/><site name="worn"/>
        </body>
        <body name="thigh">
          <joint name="knee" axis="0 1 0"/>
          <geom type="box" size="0.1 0.1 0.1"/>
          <site name="marker"/>
        </body>
      </body>
    </body>
  </worldbody>
  <sensor><gyro site="on_plate"/><accelerometer site="worn"/><framepos objtype="site" objname="marker"/></sensor>
</mujoco>
"""


@pytest.fixture(scope="module")
def chain() -> Tree:
    return tree_of(mujoco.MjSpec.from_string(CHAIN))


def test_a_chain_is_read_with_its_joints_and_imus(chain):
    assert [(s.name, s.parent) for s in chain.segments] == [("foot", None), ("shank", "foot"), ("thigh", "shank")]
    assert [(j.name, j.kind) for s in chain.segments for j in s.joints] == [
        ("root", FREE),
        ("ankle", BALL),
        ("knee", HINGE),
    ]
    assert [joint.name for joint in chain.joints] == ["ankle", "knee"]
    assert chain.carriers == {"on_plate": "foot", "worn": "shank"}
    assert chain.sites["worn"].position == (0.0, 0.05, 0.2)
    assert np.allclose(chain.sites["on_plate"].position, (0.0, 0.2, 0.1), atol=1e-15)  # rounding of a turn by 90 deg
    assert chain.sites["worn"].case == (0.04, 0.02, 0.06)


def test_a_chain_answers_for_its_ends(chain):
    assert chain.base.name == "root" and chain.floats and chain.clamps and not chain.loose
    assert chain.last.name == "thigh" and chain.joint.name == "knee" and chain.joint.axis == (0.0, 1.0, 0.0)
    assert chain.hinge == chain.joint and chain.ball is None
    assert [s.along for s in chain.segments] == [(0.0, 0.0, -1.0), (0.0, 0.0, 1.0), None]


@pytest.mark.parametrize(
    ("rig", "kind", "floats", "clamps", "carriers"),
    [
        ("hinge", HINGE, True, True, {"imu1": "segment1", "imu2": "segment2"}),
        ("pendulum", BALL, False, False, {"imu1": "segment1"}),
        ("free", FREE, True, False, {"imu1": "segment1"}),
    ],
)
def test_our_rigs_are_three_instances(rig, kind, floats, clamps, carriers):
    tree = rig_tree(rig)
    assert (tree.kind, tree.floats, tree.clamps, tree.carriers) == (kind, floats, clamps, carriers)
    assert tree.loose == (kind == FREE)
    assert RIG_SUMMARIES.keys() == RIG_FILES.keys()


@pytest.mark.parametrize("rig", RIG_FILES)
def test_the_names_of_imus_are_those_of_the_tree(rig):
    assert imu_names(rig) == rig_tree(rig).imus


def test_a_rig_that_nobody_has_read_has_nothing():
    assert rig_tree("mine.xml") is UNREAD
    assert not UNREAD.names and not UNREAD.kind and not (UNREAD.floats or UNREAD.clamps or UNREAD.loose)
    assert UNREAD.base is None and UNREAD.joint is None
    assert not any(effect.fits(UNREAD) for effect in EFFECTS.values())


def test_a_recording_says_what_moves_on_its_base():
    time = np.arange(3.0)
    imus = tuple(Imu(f"imu{n}", time, np.zeros((3, 3)), np.zeros((3, 3)), 1.0) for n in (1, 2))
    held = Recording("held", "hinge", imus, base="fixed")
    assert held.clamped and [i.name for i in held.moving] == ["imu2"] and held.carrier("imu2") == "segment2"
    assert len(Recording("in a hand", "hinge", imus).moving) == 2
    mine = Recording("one's own", "mine.xml", imus, base="fixed")
    assert not mine.clamped and len(mine.moving) == 2 and mine.carrier("imu2") == "segment2"


def test_standard_rigs_have_the_numbers_of_their_files():
    """A cylinder for each capsule, the file's own inertia where it has one; a change leaves the rest."""
    rig = standard_rig("hinge")
    model = mujoco.MjModel.from_xml_string(
        "<mujoco><worldbody><body><freejoint/>"
        '<geom type="cylinder" fromto="0.02 0 0 0.2 0 0" size="0.018" mass="0.25"/></body></worldbody></mujoco>'
    )
    # MuJoCo sorts the moments of a body, here from largest to smallest; equal but for rounding.
    assert np.allclose(np.sort(rig.segments[1].inertia), np.sort(model.body_inertia[1]), rtol=1e-12)
    assert np.allclose(rig.segments[1].com, model.body_ipos[1], atol=1e-15)
    assert standard_rig("free").segments[0].inertia.tolist() == [3e-4, 3e-4, 5e-4]
    assert hinge(gravity=1.0).gravity == 1.0 and hinge().gravity == rig.gravity
