"""The MJCF files as a person opens them in MuJoCo's viewer: the papers' rigs, with sensors, a screw and springs."""

import mujoco
import numpy as np
import pytest

from imubench.correction.rig_file import read_rig
from imubench.models import RIG_FILES, mjcf
from imubench.models.tree import rig_tree
from imubench.sim.compile import compile_model
from imubench.sim.rigs import standard_rig


@pytest.mark.parametrize("rig", RIG_FILES)
def test_every_imu_has_its_sensors_in_the_file(rig):
    model = mujoco.MjModel.from_xml_string(mjcf(rig))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    for imu in rig_tree(rig).imus:
        assert data.sensor(f"{imu}_gyro").data.shape == (3,)
        assert data.sensor(f"{imu}_accelerometer").data.shape == (3,)


@pytest.mark.parametrize("on", [False, True])
def test_the_screw_is_off_and_holds_the_hinge_where_it_is_put_in(on):
    model = mujoco.MjModel.from_xml_string(mjcf("hinge"))
    data = mujoco.MjData(model)
    screw = model.equality("screw").id
    assert not data.eq_active[screw]
    data.eq_active[screw] = on
    data.joint("hinge").qvel = 3.0
    for _ in range(200):
        mujoco.mj_step(model, data)
    # An equality of MuJoCo gives way a little to a knock of 3 rad/s; free, it turns by 0.6 rad in 0.2 s.
    assert (abs(data.sensor("encoder").data[0]) < 0.1) == on
    assert np.isfinite(data.qpos).all()


def mount_angles(model, data, kind):
    """Return where the springs of the IMUs are, along or about their axes."""
    names = [model.joint(i).name for i in range(model.njnt)]
    return np.array([data.joint(n).qpos[0] for n in names if n.startswith("imu") and f"_{kind}_" in n])


@pytest.mark.parametrize("rig", RIG_FILES)
def test_imus_sit_fast_on_their_springs_until_these_are_let_go(rig):
    model = mujoco.MjModel.from_xml_string(mjcf(rig))
    springs = [model.joint(i).name.startswith("imu") for i in range(model.njnt)]
    own = ~np.array(springs)[model.dof_jntid]
    for on in (True, False):
        data, rng = mujoco.MjData(model), np.random.default_rng(0)
        welds = [i for i in range(model.neq) if model.eq_type[i] == mujoco.mjtEq.mjEQ_WELD]
        assert data.eq_active[welds].all() and len(welds) == len(rig_tree(rig).imus)
        data.eq_active[welds] = on
        data.qvel[own] = 3.0 * rng.standard_normal(own.sum())
        data.joint("imu1_slide_x").qvel, data.joint("imu1_hinge_x").qvel = 0.0 if on else 0.1, 0.0 if on else 1.0
        slid = turned = 0.0
        for _ in range(500):
            mujoco.mj_step(model, data)
            slid = max(slid, np.abs(mount_angles(model, data, "slide")).max())
            turned = max(turned, np.abs(mount_angles(model, data, "hinge")).max())
        # 0.1 m/s at 20 Hz is 0.8 mm, 1 rad/s at 15 Hz 10 mrad; a weld of MuJoCo gives way by 5 nm, 0.1 microrad here.
        assert (slid < 1e-7 and turned < 1e-6) if on else (slid > 4e-4 and turned > 4e-3)


@pytest.mark.parametrize(("joint", "hz"), [("imu1_slide_x", 20.0), ("imu1_hinge_x", 15.0)])
def test_the_springs_have_the_frequency_that_the_file_says(joint, hz):
    model = mujoco.MjModel.from_xml_string(mjcf("free"))
    dof = int(model.joint(joint).dofadr[0])
    inertia = 0.016 if "slide" in joint else 0.016 * 0.015**2  # kg, kg m^2: the mount of `sim.rigs`
    w = np.sqrt(np.ravel(model.jnt_stiffness[model.joint(joint).id])[0] / inertia)
    assert w == pytest.approx(2 * np.pi * hz, rel=1e-4)  # five digits in the file
    assert model.dof_damping[dof] == pytest.approx(2 * 0.2 * inertia * w, rel=1e-4)


@pytest.mark.parametrize("rig", RIG_FILES)
def test_a_rig_that_is_simulated_has_none_of_the_springs_that_are_off(rig):
    model = compile_model(standard_rig(rig))
    assert [model.joint(i).name for i in range(model.njnt)] == [
        j.name for s in rig_tree(rig).segments for j in s.joints
    ]
    assert not model.neq


@pytest.mark.parametrize("rig", RIG_FILES)
def test_a_file_is_read_back_as_the_standard_rig(rig, tmp_path):
    """Springs that a weld holds are none; let go, they are a soft mount."""
    text, path = mjcf(rig), tmp_path / "rig.xml"
    path.write_text(text)
    held, standard = read_rig(path, rig), standard_rig(rig)
    for one, other in zip(held.mounts, standard.mounts, strict=True):
        assert not one.sprung and np.allclose(one.position, other.position)
        assert (one.mass, one.gyration) == pytest.approx((other.mass, other.gyration), rel=1e-12)
    path.write_text(text.replace("<weld ", '<weld active="false" '))
    for mount in read_rig(path, rig).mounts:
        assert mount.translation.frequency == pytest.approx(20.0, rel=1e-4)  # five digits in the file
        assert mount.rotation.frequency == pytest.approx(15.0, rel=1e-4)
        assert mount.rotation.damping_ratio == pytest.approx(0.2, rel=1e-4)
