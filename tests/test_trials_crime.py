"""The same questions from the project's own simulator: what it plays, what it cannot, and the comparison."""

import json

import numpy as np
import pytest

from imubench import format1, rotations
from imubench.proof.mixture import mixture
from imubench.trials import crime
from imubench.trials.crime import SUFFIX, made_simulated, simulable, simulated, simulates, twice
from imubench.trials.make import leaks, shortened
from imubench.trials.prove import prove
from imubench.trials.settings import Settings

SEED = 5
SILENT = """
import json, pathlib, sys
pair = {"before": {}, "after": {}, "unit": ""}
pathlib.Path(sys.argv[2]).mkdir()
pathlib.Path(sys.argv[2], "diagnosis.json").write_text(json.dumps({"format": 1, "recording": "recording",
  "rig": "hinge", "verdict": "no mismatch", "misfit": {"nominal": 1.0, "explained": 1.0, "unit": ""}, "where": [],
  "findings": [], "rejected": [], "fit": {"heldout": {"before": 1.0, "after": 1.0}, "left_out_channel": pair,
  "reference": pair}, "model": "", "seconds": 0.1}))
"""
OPTIONS = {
    "rig": "hinge", "seconds": 10.0, "rate": 100.0, "rate2": 50.0, "base": "free", "encoder": False, "pose": None,
    "band": 2.0, "vigour": 1.0, "gyro_noise": 1e-4, "accel_noise": 1e-3, "declare_noise": True, "misdeclared": 0.1,
    "declare_geometry": True, "position_std": 0.004, "rotation_std": 0.02, "gravity": 9.81,
}  # fmt: skip
CASES = {
    "gyro_bias": {"bias": [0.02, -0.01, 0.03]},
    "accel_drift": {"rate": [0.01, 0.02, -0.01]},
    "vibration": {"frequency": 12.0, "amplitude": [0.3, 0.5, -0.4]},
    "accel_noise": {"std": 0.05},
    "saturation": {"limit": 1.0, "channels": ["gyro"]},
    "dropouts": {"fraction": 0.2, "mode": "missing"},
    "impacts": {"times": [3.0, 6.0], "peak": 30.0},
    "mount_pose": {"rotation": [0.2, 0.0, 0.1], "translation": [0.02, 0.0, 0.0]},
    "soft_mount": {"frequency": [12.0, 13.0, 14.0], "damping_ratio": 0.1},
    "gravity": {"g": 9.7},
}


def truth(*effects, **options):
    told = [{"effect": e, "at": at, "parameters": CASES[e], "inside": True, "detail": {}} for e, at in effects]
    return {"seed": 3, "rig": "hinge", "effects": told, "options": OPTIONS | options}


@pytest.mark.parametrize("name", [n for n in CASES if n != "gravity"])
def test_an_effect_changes_its_imu_and_not_the_other(name):
    clean, changed = simulated(truth()), simulated(truth((name, "imu2")))
    assert np.allclose(clean.imus[0].accel, changed.imus[0].accel, atol=1e-9)  # one model more or less rounds otherwise
    one, two = clean.imus[1], changed.imus[1]
    assert (
        len(one.time) != len(two.time) or not np.allclose(one.gyro, two.gyro) or not np.allclose(one.accel, two.accel)
    )
    assert one.gyro_noise_std == two.gyro_noise_std == pytest.approx(1.1e-4)  # as declared, 10 % wrong


def test_sizes_are_those_of_the_truth():
    clean = simulated(truth())
    biased = simulated(truth(("gyro_bias", "imu1")))
    assert np.allclose(biased.imus[0].gyro - clean.imus[0].gyro, CASES["gyro_bias"]["bias"], atol=1e-12)  # same draws
    drifting = simulated(truth(("accel_drift", "imu1")))
    end = drifting.imus[0].accel[-1] - clean.imus[0].accel[-1]
    span = clean.imus[0].time[-1] - clean.imus[0].time[0]
    assert np.allclose(end, np.array(CASES["accel_drift"]["rate"]) * span, atol=1e-12)
    humming = simulated(truth(("vibration", "imu1"))).imus[0].accel - clean.imus[0].accel
    assert np.std(humming, axis=0) * np.sqrt(2) == pytest.approx([0.3, 0.5, 0.4], rel=0.01)  # not whole periods
    assert np.abs(simulated(truth(("saturation", "imu1"))).imus[0].gyro).max() == 1.0


def test_a_mount_is_off_by_the_truth_from_where_it_is_declared(monkeypatch):
    rigs, played = [], crime.play
    monkeypatch.setattr(crime, "play", lambda rig, *rest, **named: rigs.append(rig) or played(rig, *rest, **named))
    recording = simulated(truth(("mount_pose", "imu2")))
    placed, declared = rigs[0].mounts[1], recording.imus[1]
    turn = rotations.log(rotations.multiply(rotations.conjugate(declared.mount_quaternion), placed.quaternion))
    assert turn == pytest.approx(np.array(CASES["mount_pose"]["rotation"]), abs=1e-12)
    assert placed.position - declared.mount_position == pytest.approx([0.02, 0.0, 0.0], abs=1e-12)


@pytest.mark.long
def test_what_the_simulator_cannot_do_is_told_and_the_rest_is_played(tmp_path):
    asked = {f"{i:03d}": shortened(q, 4.0) for i, q in enumerate(mixture(SEED, 40))}
    again = twice(asked)
    why = {name: simulable(q) for name, q in asked.items()}
    assert {name + SUFFIX for name in asked if not why[name]} == set(again)
    assert {"outside the table", "free swing"} <= set(why.values())
    for name, one in list(again.items())[:6]:
        told = made_simulated(one, tmp_path / name / "recording")
        assert leaks(tmp_path / name / "recording", told) == []
        assert all(simulates(e["effect"]) for e in told["effects"])
        assert format1.read(tmp_path / name / "recording")[0].imus[-1].time[-1] <= 4.0


def test_gravity_acts_on_the_world_and_is_not_declared():
    heavy, usual = (simulated(truth(*e, base="fixed")) for e in ([("gravity", "world")], []))
    assert heavy.gravity == usual.gravity == 9.81
    ratio = np.linalg.norm(heavy.imus[0].accel.mean(axis=0)) / np.linalg.norm(usual.imus[0].accel.mean(axis=0))
    assert ratio == pytest.approx(9.7 / 9.81, rel=1e-4)  # noise of 1e-3 averaged over 1000 samples


@pytest.mark.long
def test_a_proof_compares_both_ways_on_the_same_questions(tmp_path):
    (tmp_path / "silent.py").write_text(SILENT)
    settings = Settings(4, SEED, f"{tmp_path / 'silent.py'} {{recording}} {{out}}", seconds=6.0, crime=True)
    done = prove(settings, tmp_path / "out", 2, lambda *seen: None, lambda sealed: None)
    assert len(done.scores) == 4 and len(done.simulated) + len(done.not_simulated) == 4 and done.simulated
    content = json.loads((tmp_path / "out" / "proof.json").read_text())["crime"]
    answered = next(row for row in content["figures"] if row["name"] == "answered")
    assert answered["generator_n"] == answered["sim_n"] == len(done.simulated)
    assert answered["difference"] == 0.0
    assert "inverse crime" in (tmp_path / "out" / "report.html").read_text()
