"""What a `model/` plays the judge plays too, and what moves by a clock or by forces does so inside a roll-out."""

import tomllib
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from imubench import rotations
from imubench.correction.export import write_model
from imubench.correction.found_chain import chain_of
from imubench.correction.read_model import read_model
from imubench.correction.sensor_chain import angle_read, read_by
from imubench.diagnosis.evidence import Evidence, FittedEffect, Level, Played, Swing
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.residual_checks import fit_summary
from imubench.diagnosis.result import Diagnosis, Finding, FitQuality, Interval, Parameter
from imubench.diagnosis.simulation.channels import simulated
from imubench.diagnosis.simulation.model_folder import played_early
from imubench.diagnosis.simulation.rollout import rolled_out
from imubench.diagnosis.simulation.sim_model import finding_of, named, playable, sim_model
from imubench.diagnosis.simulation.splice import rolled_truth
from imubench.diagnosis.solve.gauss_newton import extended
from imubench.effects import EFFECTS
from imubench.format1 import read
from imubench.proof.case import make_case
from imubench.recording import Body, Encoder, Recording
from imubench.sim.rigs import Mount, Segment, Slip, hinge, pendulum
from imubench.sim.swing import Start

GAIN = Interval(9.0, (8.0, 9.5))
LIMB = Segment(1.3, np.array([0.004, -0.003, -0.2]), np.array([0.02, 0.018, 0.003]))
NUMBERS = {
    ("rocking_mount", "imu2"): {
        "frequency": np.log([9.0, 8.0, 10.0]),
        "damping_ratio": np.log([0.2] * 3),
        "com": [0.0, 2e-3, 3e-3],
    },
    ("time_offset", "imu2"): {"offset": [0.01]},
    ("low_pass", "imu1"): {"cutoff": np.log([8.0])},
    ("gyro_drift", "imu1"): {"rate": [0.01, -0.02, 0.0]},
    ("mount_shift", "imu1"): {"rotation": [0.1, 0.0, 0.05], "translation": [0.0, 0.01, 0.0], "time": [2.0]},
    ("axis_coupling", "joint"): {"coupling": [0.1, -0.1]},
    ("moving_centre", "joint"): {"slide": [0.02, 0.0, 0.01]},
    ("skin_sliding", "imu2"): {"slide": [0.01, 0.0, 0.02], "twist": [0.0, 0.1, 0.0]},
}
"""Numbers of effects as a fit holds them: logarithms of what is above zero."""


def said(*findings, rig="hinge"):
    verdict = "explained" if findings else "no mismatch"
    if findings and not any(f.named for f in findings):
        verdict = "unexplained"
    return Diagnosis("rec", rig, verdict, (4.0, 1.0), (), findings, (), FitQuality((4.0, 1.0)), "", 1.0)


@pytest.mark.long
@pytest.mark.parametrize("case", NUMBERS, ids=lambda case: "@".join(case))
def test_the_judge_reads_what_the_model_on_disk_reads(case, tmp_path):
    """The fit is not solved: what counts is that both play the same numbers."""
    make_case(tmp_path / "r", "hinge", [], 3, seconds=4.0)
    recording = read(tmp_path / "r")[0]
    plain = nominal_fit(recording)
    h = Hypothesis(EFFECTS[case[0]], case[1])
    fit = extended(plain, (h,), {h.key(name): np.array(value, dtype=float) for name, value in NUMBERS[case].items()})
    assert playable(fit, h)
    found = tuple(replace(finding_of(fit, h), heldout_gain=GAIN) for h in named(fit))
    weighed = fit_summary.weighed(plain, {})
    evidence = Evidence(
        recording, fit_summary.traces(weighed), fit_summary.played(fit), fit_summary.mounts(fit), weighed.levels
    )
    write_model(said(*found), evidence, tmp_path)
    (effect,) = tomllib.loads((tmp_path / "imus.toml").read_text())["effect"]
    assert effect["replayed"]
    model = read_model(tmp_path)
    truth, first = played_early(model)  # a clock that is late reads what was before the first sample
    judged, without = (simulated(sim_model(one), recording, ()).channels for one in (fit, plain))
    changed = 0.0
    for imu in recording.imus:
        _, *both = read_by(truth, model.start, imu.time, imu.name, model.chain(imu.name), first=first - model.start)
        for values, names, off in zip(both, ("gyr", "acc"), (1e-3, 2e-2), strict=True):
            for axis, one in zip("xyz", values.T, strict=True):
                channel = f"{imu.name}.{names}_{axis}"
                # six digits of the MJCF file, and springs that begin half a row apart
                assert_allclose(one, judged[channel], atol=off, err_msg=channel)
                changed = max(changed, float(np.abs(judged[channel] - without[channel]).max()) / off)
    assert changed > 3


def test_a_slip_keeps_its_time_in_a_roll_out():
    """A sensor that slips 7 s after the recording's start, in a window that begins at 5 s of it."""
    slip = Slip(7.0, np.array([0.0, 0.05, 0.0]))
    rig = replace(pendulum(mounts=(Mount(np.array([0.0, 0.0, -0.2]), slip=slip),)), segments=(LIMB,))
    turned = rotations.exp(np.array([0.0, 0.4, 0.0]))
    truth = rolled_truth(rig, Swing(105.0, 109.0, Start(quaternion=turned)), 100.0, 100.0)
    segment, sensor = truth.segments[0], truth.sensor("imu1")
    off = rotations.rotate_back(segment.quaternion, sensor.position - segment.position)
    moved = off[:, 1]
    assert_allclose(moved[truth.time < 1.9], 0.0, atol=1e-6)  # m; it slips 2 s behind the window's start
    assert_allclose(moved[truth.time > 2.4], 0.05, atol=1e-6)  # the change takes a fifth of a second


def test_dry_friction_stops_a_limb_on_a_ball_joint_as_its_equation_says():
    """I w' + w x I w = c x m R' g - t w / sqrt(w.w + 1e-6) in segment axes, R' = R [w]; integrated here by itself."""
    com = LIMB.com
    inertia = np.diag(LIMB.inertia) + LIMB.mass * (com @ com * np.eye(3) - np.outer(com, com))

    def slope(_, y):
        q, w = y[:4] / np.linalg.norm(y[:4]), y[4:]
        down = Rotation.from_quat(q).inv().apply([0, 0, -9.81])
        torque = np.cross(com, LIMB.mass * down) - 0.1 * w / np.sqrt(w @ w + 1e-6) - np.cross(w, inertia @ w)
        x, s = q[:3], q[3]
        return np.concatenate([0.5 * (s * w + np.cross(x, w)), [-0.5 * x @ w], np.linalg.solve(inertia, torque)])

    start, w = Rotation.from_rotvec([0.7, 0.4, 0.2]), np.array([0.3, -1.0, 1.5])
    rig = replace(pendulum(dry_friction=0.1), segments=(LIMB,))
    swing = Swing(0.0, 2.5, Start(quaternion=start.as_quat()[[3, 0, 1, 2]], rate=w))
    found = rolled_out(rig, swing, 200.0)
    y = solve_ivp(slope, (0, 2.6), [*start.as_quat(), *w], t_eval=found.time, rtol=1e-8, atol=1e-10).y
    apart = Rotation.from_quat(found.quaternion1[:, [1, 2, 3, 0]]).inv() * Rotation.from_quat(y[:4].T)
    assert np.max(apart.magnitude()) < 1e-4  # rad: of order 2 in steps of 1 ms


def arm(rig="hinge"):
    """What a diagnosis of an arm on a fixed base would write: a motion, a window that is rolled out."""
    time, rows = np.arange(0.0, 4.0, 5e-3), np.arange(-0.2, 4.2, 0.02)
    body = Body(LIMB.mass, LIMB.com, LIMB.inertia)
    recording = Recording(
        *("rec", rig), encoders=(Encoder("hinge", time, 0 * time),), base="fixed", body=body, motion="free",
        free_swings=((0.0, 3.9),),
    )  # fmt: skip
    still = np.broadcast_to([1.0, 0, 0, 0], (rows.size, 4))
    motion = Played(rows, still, np.zeros((rows.size, 3)), 0 * rows)
    swings = (Swing(0.0, 3.9, Start(angle=1.2)),)
    return Evidence(recording, (), motion, {}, (Level("encoder.angle", "rad", None, 1e-12, 1e-12),), rolled_out=swings)


def test_a_torque_without_a_name_is_played_where_a_swing_is_rolled_out(tmp_path):
    evidence = arm()
    time = np.arange(-0.5, 4.5, 5e-3)
    pushed = FittedEffect("unknown", "joint", time=time, signals={"torque": 0.3 * np.sin(5 * time)[:, None]})
    evidence = replace(evidence, motion=replace(evidence.motion, fitted=(pushed,)))
    strange = said(Finding("unknown", "joint", 0.9, {}, GAIN))
    folders = {name: tmp_path / name for name in ("swings", "held")}
    for name, folder in folders.items():
        folder.mkdir()
        write_model(strange, evidence if name == "swings" else replace(evidence, rolled_out=()), folder)
        (effect,) = tomllib.loads((folder / "imus.toml").read_text())["effect"]
        assert effect["replayed"] is (name == "swings")
    model = read_model(folders["swings"])
    stamps = np.arange(0.05, 3.8, 0.01)
    truth, first = played_early(model)
    angle = angle_read(truth, model.start, stamps, model.effects, first - model.start)
    x, _, z = LIMB.com
    inertia = LIMB.inertia[1] + LIMB.mass * (x**2 + z**2)

    def slope(t, y):
        weight = LIMB.mass * 9.81 * (x * np.cos(y[0]) + z * np.sin(y[0]))
        return [y[1], (weight + 0.3 * np.sin(5 * t)) / inertia]

    expected = solve_ivp(slope, (0, 3.9), [1.2, 0.0], t_eval=stamps, rtol=1e-9, atol=1e-11).y[0]
    assert_allclose(angle, expected, atol=3e-4)  # rad: lines through the torque's rows 5 ms apart, the file's digits
    alone = solve_ivp(lambda t, y: [y[1], slope(0.0, y)[1]], (0, 3.9), [1.2, 0.0], t_eval=stamps, rtol=1e-9).y[0]
    assert np.abs(alone - expected).max() > 0.05


def test_a_backlash_goes_on_from_where_it_stood():
    """What an encoder reads of a window does not depend on where the simulation's rows begin."""
    recording = arm().recording
    time = np.arange(0.0, 4.0, 5e-3)
    angle = np.sin(3 * time)
    gap = angle - EFFECTS["backlash"].played(angle, 0.05)
    own = FittedEffect("backlash", "joint", time=time, signals={"gap": gap[:, None]})
    numbers = {"range": Parameter(0.05, 1e-3, "rad")}
    chain = chain_of([Finding("backlash", "joint", 0.9, numbers, GAIN)], (own,), recording)
    rig = hinge(base="fixed")
    truth = rolled_truth(rig, Swing(0.0, 0.5, Start()), 200.0, 0.0)
    still = np.zeros(time.size)
    whole = replace(
        truth,
        time=time,
        segments=(),
        sensors=(),
        joint_angle=angle,
        joint_rate=still,
    )
    later = replace(whole, time=time[:400], joint_angle=angle[400:], joint_rate=still[400:])
    stamps = np.arange(2.0, 3.9, 0.01)
    assert_allclose(angle_read(later, 0.0, stamps, chain, first=2.0), angle_read(whole, 0.0, stamps, chain), atol=1e-9)
