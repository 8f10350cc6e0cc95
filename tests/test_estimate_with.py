"""A recording corrected with its diagnosis: what an effect added is gone, what has no law stays, estimators gain.

The recordings come from the generator in `proof/`, which shares no code with the diagnosis nor the effects. The same
seed makes the same motion and the same noise with and without an effect, so samples can be compared one by one.
"""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from imubench import rotations
from imubench.answers import moved
from imubench.cli import app
from imubench.correction.corrected import corrected
from imubench.diagnosis.pipeline import diagnose
from imubench.diagnosis.result import Diagnosis, Finding, FitQuality, Interval, Parameter
from imubench.diagnosis.result_file import as_dict
from imubench.errors import InputError
from imubench.estimate import Estimate
from imubench.format1 import read
from imubench.proof.case import make_case
from imubench.recording import Recording
from imubench.run import estimate, estimate_on_disk
from imubench.score import axis_deviation

SECONDS = 10.0
GAIN = Interval(100.0, (90.0, 110.0))


def made(folder: Path, rig: str, effects: list, seed: int = 1, **options) -> tuple[Recording, dict]:
    """A recording with and, by the same seed, one without effects; and the truth of the first."""
    options = {"seconds": SECONDS, "name": "case"} | options
    truth = make_case(folder, rig, effects, seed, "strong", **options)
    return read(folder)[0], truth


def finding(effect: str, at: str, confidence: float = 0.98, **parameters) -> Finding:
    """A finding with these parameters."""
    values = {n: Parameter(np.asarray(v, dtype=float), np.zeros(np.shape(v)), "") for n, v in parameters.items()}
    return Finding(effect, at, confidence, values, GAIN)


def saying(recording: Recording, *findings: Finding) -> Diagnosis:
    """A diagnosis with these findings."""
    sure = [f for f in findings if f.confidence >= 0.5]
    verdict = "explained" if any(f.named for f in sure) else "unexplained" if sure else "no mismatch"
    if verdict == "explained" and not all(f.named for f in sure):
        verdict = "partly explained"
    quality = FitQuality((1.0, 1.0))
    return Diagnosis(recording.name, recording.rig, verdict, (1.0, 1.0), (), findings, (), quality, "", 1.0)


def told(truth: dict) -> list[Finding]:
    """A case's truth in the words of a diagnosis."""
    out = []
    for e in truth["effects"]:
        known = {k: v for k, v in e["parameters"].items() if k not in ("channels", "gyration", "mode")}
        out.append(finding(e["effect"], e["at"], **known))
    return out


def rms(x) -> float:
    return float(np.sqrt(np.mean(np.square(x))))


def left(clean: Recording, raw: Recording, after: Recording) -> dict[str, float]:
    """By channel that an effect changed: what is left of its change, RMS over RMS."""
    out = {}
    for one, two, three in zip(clean.imus, raw.imus, after.imus, strict=True):
        kept = np.isin(two.time, three.time)
        for part, noise in (("gyro", 0.002), ("accel", 0.02)):
            a, b, c = getattr(one, part)[kept], getattr(two, part)[kept], getattr(three, part)
            if rms(b - a) > 0.1 * noise:
                out[f"{one.name}.{part}"] = rms(c - a) / rms(b - a)
            else:
                assert rms(c - a) < 0.1 * noise  # a channel that an effect does not touch is not touched
    assert out
    return out


LAWS = {  # effect: rig, place, what may be left of its change
    "gyro_bias": ("pendulum", "imu1", 1e-5),  # the diagnosed number itself, whatever the fit
    "gyro_misalignment": ("pendulum", "imu1", 0.005),  # the fit's rate, 0.1 % of the true one, takes its place
    "accel_scale": ("pendulum", "imu1", 0.005),
    "mount_shift": ("hinge", "imu2", 0.01),
    "skin_sliding": ("hinge", "imu1", 0.05),  # the fit's second derivative of the hinge angle is in it
    "axis_coupling": ("hinge", "joint", 0.03),
    "vibration": ("pendulum", "imu1", 0.1),  # its phase is fitted
    "rocking_mount": ("pendulum", "imu1", 0.04),
    "low_pass": ("pendulum", "imu1", 0.1),  # what a filter took must be put back by the fit
    "soft_mount": ("pendulum", "imu1", 0.4),  # nothing is left below 4 Hz, but noise comes in about the resonance
}
SLOW = ("rocking_mount", "low_pass", "soft_mount", "skin_sliding", "axis_coupling", "mount_shift")


@pytest.mark.parametrize("name", [pytest.param(n, marks=[pytest.mark.slow] if n in SLOW else []) for n in LAWS])
def test_what_an_effect_added_is_gone_and_the_noise_stays(name, tmp_path):
    rig, at, most = LAWS[name]
    raw, truth = made(tmp_path / "raw", rig, [(name, at)])
    clean, _ = made(tmp_path / "clean", rig, [])
    done = corrected(raw, saying(raw, *told(truth)))
    assert [d.what for d in done.done] == ["taken out of the readings"]
    assert max(left(clean, raw, done.recording).values()) < most


def test_a_late_clock_is_set_and_no_sample_touched(tmp_path):
    raw, truth = made(tmp_path / "raw", "hinge", [("time_offset", "imu2"), ("clock_skew", "imu2")])
    p = [e["parameters"] for e in truth["effects"]]
    start = min(i.time[0] for i in raw.imus)
    after = corrected(raw, saying(raw, *told(truth))).recording
    one, two = raw.imus[1], after.imus[1]
    exact = (one.time - start - p[0]["offset"]) / (1 + p[1]["skew"]) + start  # the contract's law
    assert np.abs(two.time - exact).max() < abs(p[0]["offset"] * p[1]["skew"]) + 1e-12  # which of them acts first
    assert np.array_equal(one.gyro, two.gyro) and np.array_equal(one.accel, two.accel)
    assert np.array_equal(after.imus[0].time, raw.imus[0].time)


def test_a_mount_and_gravity_are_declared_anew_and_no_sample_touched(tmp_path):
    raw, truth = made(tmp_path / "raw", "free", [("mount_pose", "imu1"), ("gravity", "world")])
    after = corrected(raw, saying(raw, *told(truth))).recording
    true, p = truth["mounts"][0], truth["effects"][0]["parameters"]
    assert after.gravity == pytest.approx(truth["effects"][1]["parameters"]["g"])
    assert after.imus[0].mount_position == pytest.approx(np.add(true["position"], p["translation"]))
    turned = rotations.multiply(np.array(true["quaternion"]), rotations.exp(np.array(p["rotation"])))
    assert abs(after.imus[0].mount_quaternion @ turned) == pytest.approx(1.0, abs=1e-12)
    assert np.array_equal(after.imus[0].gyro, raw.imus[0].gyro)


def test_what_has_no_law_or_is_not_sure_is_left_and_said(tmp_path):
    raw, _ = made(tmp_path / "raw", "hinge", [])
    faint = finding("gyro_bias", "imu1", 0.3, bias=[0.1, 0, 0])
    vague = finding("unknown", "imu2")
    play = finding("joint_play", "joint", range=0.02, direction=0.3)
    friction = finding("viscous_friction", "joint", c=0.1)
    done = corrected(raw, saying(raw, vague, faint, play))
    assert [d.what.split(":")[0] for d in done.done] == ["left in"] * 3
    for one, two in zip(raw.imus, done.recording.imus, strict=True):
        assert np.array_equal(one.gyro, two.gyro) and np.array_equal(one.accel, two.accel)
    with pytest.raises(InputError, match="viscous_friction at joint: expected no place"):
        corrected(raw, saying(raw, friction))  # there is no free swing in it


def test_samples_that_are_no_measurement_are_left_out_and_loud_noise_declared(tmp_path):
    raw, truth = made(tmp_path / "raw", "pendulum", [("saturation", "imu1", {"limit": 2.0, "channels": ["gyro"]})])
    noisy = finding("accel_noise", "imu1", std=0.05)
    after = corrected(raw, saying(raw, *told(truth), noisy)).recording.imus[0]
    clipped = np.abs(raw.imus[0].gyro).max(axis=1) >= 2.0 - 1e-6
    assert clipped.sum() > 20 and np.abs(after.gyro).max() < 2.0
    assert after.time.size < raw.imus[0].time.size - clipped.sum() + 1
    assert after.accel_noise_std == pytest.approx(0.05)


@pytest.mark.parametrize(
    ("findings", "message"),
    [
        ([finding("gyro_byas", "imu1")], "finding gyro_byas at imu1: expected an effect of `imubench list`"),
        (
            [finding("gyro_bias", "joint", bias=[0, 0, 0])],
            "gyro_bias at joint: expected imu1, imu2 in case on rig hinge",
        ),
        ([finding("gyro_bias", "imu1", bias=[0, 0])], r"expected the parameters bias \(3,\), got bias \(2,\)"),
    ],
)
def test_a_finding_that_cannot_be_is_refused(findings, message, tmp_path):
    raw, _ = made(tmp_path / "raw", "hinge", [], seconds=5.0)
    with pytest.raises(InputError, match=message):
        corrected(raw, saying(raw, *findings))


def written(folder: Path, d: Diagnosis, model: str = "") -> Path:
    """A diagnosis on disk."""
    folder.mkdir()
    (folder / "diagnosis.json").write_text(json.dumps(as_dict(d)))
    if model:
        (folder / "model").mkdir()
        (folder / "model" / "imus.toml").write_text(model)
    return folder


def test_the_command_takes_a_folder_writes_what_it_took_and_says_what_it_did(tmp_path):
    raw, truth = made(tmp_path / "raw", "pendulum", [("accel_bias", "imu1")])
    diagnosis = written(tmp_path / "diag", saying(raw, *told(truth), finding("unknown", "imu1")))
    done = CliRunner().invoke(
        app, ["estimate", "mrvs", *map(str, (tmp_path / "raw", "--with", diagnosis, "--out", tmp_path / "out"))]
    )
    assert done.exit_code == 0, done.output
    assert "accel_bias at imu1: taken out of the readings" in done.output
    assert "unknown at imu1: left in: no law to correct it by" in done.output
    content = json.loads((tmp_path / "out" / "estimate.json").read_text())
    assert content["with"]["verdict"] == "partly explained" and len(content["with"]["findings"]) == 2
    came, went = (estimate("mrvs", one) for one in (raw, read(tmp_path / "out" / "corrected")[0]))
    apart = 1e3 * np.linalg.norm(came.value - went.value, axis=-1)
    assert content["with"]["moved"] == {"joint_vector": {"value": pytest.approx(apart.tolist()), "unit": "mm"}}
    assert f"moved by what was taken out: imu1 {apart[0]:.2f} mm (as it came: converged)" in done.output
    after = read(tmp_path / "out" / "corrected")[0].imus[0]
    assert after.accel == pytest.approx(raw.imus[0].accel - truth["effects"][0]["parameters"]["bias"], abs=1e-6)


def test_by_how_much_two_estimates_differ():
    one = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
    other = -np.array([[0.0, np.cos(0.1), np.sin(0.1)], [1.0, 0.0, 0.0]])  # the other sign of both
    axes = [Estimate("joint_axis", "x", value, None, "none") for value in (one, other)]
    value, unit = moved(*axes)
    assert unit == "deg" and value == pytest.approx([np.degrees(0.1), 0.0], abs=1e-5)

    stamps = np.arange(5.0)
    vectors = np.zeros((5, 1, 3))
    kept = np.array([0, 1, 3, 4])  # two samples were left out
    beside = vectors[kept] + np.array([0.003, 0.004, 0.0])
    series = [
        Estimate("joint_vector", "x", v, None, "none", time=t) for v, t in ((vectors, stamps), (beside, stamps[kept]))
    ]
    value, unit = moved(*series)
    assert unit == "mm" and value == pytest.approx([5.0])
    assert moved(series[0], replace(series[1], time=stamps[kept] + 0.5)) is None  # no stamp in common


def test_a_diagnosis_of_another_recording_is_refused(tmp_path):
    raw, _ = made(tmp_path / "raw", "hinge", [], seconds=5.0)
    other = written(tmp_path / "a", replace(saying(raw), recording="other"))
    longer = "format = 1\n[[imu]]\nname = 'imu1'\nsamples = 7\nstart = 0.0\n"
    same_name = written(tmp_path / "b", replace(saying(raw), model="model/hinge.xml"), longer)
    for folder, message in (
        (other, "expected that of a recording of name 'case', got of 'other'"),
        (same_name, "got 7 from 0.0 s on: the diagnosis of another recording"),
        (tmp_path / "none", "expected a file, got nothing of that name"),
    ):
        with pytest.raises(InputError, match=message):
            estimate_on_disk("seel2012", tmp_path / "raw", tmp_path / "out", diagnosis=folder)
    assert not (tmp_path / "out").exists()


def error(recording: Recording, truth: dict, name: str) -> float:
    """The larger error of both IMUs: rad of an axis, m of a joint vector."""
    value = estimate(name, recording).value
    quaternions = [np.array(m["quaternion"]) for m in truth["mounts"]]
    if name in ("olsson2020", "seel2012"):
        return float(
            axis_deviation(value, np.stack([rotations.rotate_back(q, [0.0, 1.0, 0.0]) for q in quaternions])).max()
        )
    r = np.stack(
        [rotations.rotate_back(q, -np.array(m["position"])) for q, m in zip(quaternions, truth["mounts"], strict=True)]
    )
    return float(np.linalg.norm(value - r, axis=-1).max())


GAINS = [  # rig, effect, at, estimator, the least that it spoils, how much worse than without it the corrected may be
    ("hinge", "gyro_misalignment", "imu2", "seel2012", 0.04, 5e-4),
    ("hinge", "mount_shift", "imu2", "seel2012", 0.03, 5e-4),
    ("hinge", "time_offset", "imu2", "seel2012", 0.05, 5e-4),
    ("hinge", "rocking_mount", "imu1", "hinge-position", 0.002, 1e-3),
    ("pendulum", "accel_bias", "imu1", "mrvs", 0.005, 5e-4),
    ("pendulum", "mount_shift", "imu1", "mrvs", 0.01, 5e-3),
]


@pytest.mark.slow
@pytest.mark.parametrize(("rig", "effect", "at", "name", "spoilt", "near"), GAINS, ids=lambda x: str(x))
def test_from_the_recording_alone_an_estimator_is_as_good_as_without_the_effect(
    rig, effect, at, name, spoilt, near, tmp_path
):
    """Diagnosed, corrected, estimated: nothing but the recording is known."""
    raw, truth = made(tmp_path / "raw", rig, [(effect, at)], seed=2, seconds=25.0)
    clean, undisturbed = made(tmp_path / "clean", rig, [], seed=2, seconds=25.0)
    after = corrected(raw, diagnose(raw)[0]).recording
    usual = error(clean, undisturbed, name)
    assert error(raw, truth, name) > usual + spoilt
    assert error(after, truth, name) < usual + near
