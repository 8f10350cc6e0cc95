"""Rigs from outside the package: listed, played, recorded, swept and diagnosed as ours; a bad one is one line."""

import csv
import json
import re
import sys
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from imubench.checks.claim import load_claims
from imubench.dataset.spec import parse_spec
from imubench.diagnosis.pipeline import diagnose
from imubench.errors import InputError
from imubench.models import RIG_SUMMARIES, is_rig, known_rigs, mjcf
from imubench.models.outside import rig_key
from imubench.models.tree import BALL, FREE, rig_tree
from imubench.recording import Imu, Recording
from imubench.run import simulate
from imubench.scenarios.hinge import hand_motion
from imubench.sim.imu_model import Declared, DeclaredMount, observe
from imubench.sim.imu_profile import ChannelProfile, ImuProfile
from imubench.sim.play import play
from imubench.sim.rigs import standard_rig
from tests.command import here
from tests.test_plugins import imports_as_before, installed, written  # noqa: F401

PAGE = (Path(__file__).resolve().parent.parent / "docs" / "your-rig.md").read_text()
(THEIRS,) = re.findall(r"```python\n(# their_rigs\.py.*?)```", PAGE, flags=re.DOTALL)
(SAME_NAME,) = re.findall(r'"imubench.rigs"\]\n(.*?)\n', PAGE)  # "knee = ..." of the page's pyproject.toml
LIMB = """
    <body name="leg" pos="1 2 3">
      <joint type="ball" pos="0.1 0 0"/><geom type="capsule" fromto="0.1 0 0 0.1 0.5 0" size="0.05" mass="5"/>
      <site name="a" pos="0.1 0.2 0.05"/>{more}
    </body>"""
BODY = '<body name="box" pos="1 2 3"><freejoint/><geom size="0.1" mass="1"/><site name="a" pos="0.1 0 0"/>{more}</body>'
READ = '<sensor><gyro site="a"/><accelerometer site="a"/></sensor>'


def offering(site: Path, *, package: str = "their-rigs", **rigs: str) -> None:
    """Have a package offer rigs by name, each the bodies and sensors of an MJCF file."""
    module = package.replace("-", "_")
    bodies = {name: text if "<sensor" in text else text + "\0" + READ for name, text in rigs.items()}
    files = {n: "<mujoco><worldbody>" + t.replace("\0", "</worldbody>") + "</mujoco>" for n, t in bodies.items()}
    lines = ["from imubench.models import RigFile", *(f"{n} = RigFile({n!r}, {t!r})" for n, t in files.items())]
    written(site / f"{module}.py", "\n".join(lines) + "\n")
    installed(site, package, "\n".join(f"{n} = {module}:{n}" for n in rigs), "imubench.rigs")


@pytest.fixture
def knee(tmp_path, monkeypatch):
    """The package of the page, installed."""
    monkeypatch.chdir(tmp_path)
    written(tmp_path / "site" / "their_rigs.py", THEIRS)
    installed(tmp_path / "site", "their-rigs", SAME_NAME.replace('"', ""), "imubench.rigs")
    return tmp_path


def test_the_rig_of_the_page_is_listed_explained_run_and_estimated(knee):
    assert known_rigs()["knee"] == "from package their-rigs 1.2"
    assert "knee" in here("list", "rigs").out and "knee-hand" in here("list", "scenarios").out
    said = " ".join(here("explain", "knee").out.split())
    assert "a thigh and a shank with a foot" in said
    assert "segment2 on hinge (hinge); imu2 at [0.15, 0.049752, 0.004975] m" in said
    done = here("run", "knee-hand", "--duration", "12", "--out", "played")
    assert done.code == 0, done.err
    figures = json.loads(Path("played/score.json").read_text())["figures"]
    assert figures["maxae"]["value"] < np.deg2rad(1)  # 12 s of a hand
    assert 'rig = "knee"' in Path("played/recording/recording.toml").read_text()
    assert here("estimate", "seel2012", "played/recording", "--out", "again").code == 0
    source = Path("played/recording/imu1.csv")
    done = here("convert", "csv", source, "--option", "second=imu2.csv", "--option", "rig=knee", "--out", "mine")
    assert done.code == 0, done.err
    assert 'rig = "knee"' in Path("mine/recording.toml").read_text()


def model_of(text: str, angle: float) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """Return an MJCF file compiled, its hinge at an angle in rad."""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.qpos[-1] += angle
    mujoco.mj_forward(model, data)
    return model, data


@pytest.mark.parametrize("angle", [0.0, 0.7, -1.2])
def test_the_bench_has_the_same_rig_in_its_own_frames(knee, angle):
    """Pose of one IMU seen from the other, and what the hinge carries: whichever frames the file was written in."""
    theirs, ours = THEIRS.split('"""')[1], mjcf("knee")
    poses, inertias = [], []
    for text, sites in ((theirs, ("thigh_imu", "shank_imu")), (ours, ("imu1", "imu2"))):
        _, data = model_of(text, angle)
        first, second = (data.site(name) for name in sites)
        axes = first.xmat.reshape(3, 3)
        poses.append((axes.T @ (second.xpos - first.xpos), axes.T @ second.xmat.reshape(3, 3)))
        light = mujoco.MjSpec.from_string(text)
        for sensor in list(light.sensors):
            light.delete(sensor)
        for name in ("imu1", "imu2"):
            if light.body(name) is not None:
                light.delete(light.body(name))  # 16 g that the file does not have
        model = light.compile()
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        full = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, full)
        inertias.append((model.body_mass.sum(), full[-1, -1]))
    for theirs_, ours_ in zip(*poses, strict=True):
        assert np.allclose(theirs_, ours_, atol=1e-9)  # twelve digits in the file
    assert np.allclose(*inertias, rtol=1e-9)


def test_a_limb_and_a_free_body_are_rigs_too(tmp_path):
    """The limb hangs along -z from its pivot; a free body keeps the frame of its file."""
    offering(tmp_path, limb=LIMB.format(more=""), box=BODY.format(more=""))
    limb, box = rig_tree("limb"), rig_tree("box")
    assert (limb.kind, limb.carriers, limb.ball.name) == (BALL, {"imu1": "segment1"}, "base")
    assert np.allclose(limb.last.along, (0, 0, -1))
    assert np.allclose(limb.sites["imu1"].position, (0, -0.05, -0.2), atol=1e-9) or np.allclose(
        limb.sites["imu1"].position, (0, 0.05, -0.2), atol=1e-9
    )
    assert (box.kind, box.sites["imu1"].position) == (FREE, (0.1, 0.0, 0.0))
    for rig in ("limb", "box"):
        recording, truth = simulate(f"{rig}-hand", 1)
        assert (recording.rig, truth.rig, len(recording.imus)) == (rig, rig, 1)
    assert standard_rig("limb").segments[0].mass == 5.0


SECOND = BODY.format(more="").replace("box", "2").replace('"a"', '"c"')
FLAT = '<geom type="box" size="0.3 0.05 0.01" pos="0.2 0.2 0" euler="0 0 30" mass="9"/>'
KNEE = '<body name="shank"><joint name="knee" {joint}/><geom size="0.1" mass="1"/><site name="b"/>{more}</body>'
TWO = READ.replace("</sensor>", '<gyro site="b"/></sensor>')
THREE = KNEE.format(joint="", more='<body name="foot"><joint/><geom size="0.1"/></body>')


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (BODY.format(more="").replace('name="box" ', ""), "expected a name of every body that a joint moves, got none"),
        (
            BODY.format(more=THREE) + "\0" + TWO,
            r"or one on a free joint .*, got box \(free\), shank \(hinge\), foot \(h",
        ),
        (BODY.format(more="") + SECOND, r"got box \(free\), 2 \(free\)"),
        ('<body name="wall"><geom size="0.1"/><site name="a"/></body>', r"got wall \(fixed\)"),
        ("", "expected an MJCF model, got|got no body"),
        (BODY.format(more=KNEE.format(joint="", more="")), "expected one site .* on shank, got none"),
        (BODY.format(more=KNEE.format(joint='range="0 90"', more="")) + "\0" + TWO, "expected knee without a range"),
        (BODY.format(more=KNEE.format(joint='damping="1"', more="")) + "\0" + TWO, "expected knee without a damping"),
        (
            BODY.format(more=KNEE.format(joint='axis="1 0.1 1e308"', more="")) + "\0" + TWO,
            "expected a direction as the axis",
        ),
        (
            BODY.format(more='<body pos="1e200 0 0"><geom size="0.1" mass="1"/></body>'),
            "lengths and masses that can be reckoned with",
        ),
        (LIMB.format(more=FLAT), "got products of inertia of .* of its largest moment"),
        (BODY.format(more='<geom type="mesh" mesh="x"/>'), "expected an MJCF model, got"),
        (BODY.format(more="<geom/") + "\0" + READ, "expected XML, got"),
        (BODY.format(more='<include file="x.xml"/>'), "expected a model that reads no other file"),
    ],
)
def test_a_rig_that_is_none_of_ours_is_one_line(tmp_path, text, message):
    offering(tmp_path, bad=text)
    assert "bad" in known_rigs()  # and hinders nobody
    for asked in (lambda: rig_tree("bad"), lambda: simulate("bad-hand"), lambda: standard_rig("bad")):
        with pytest.raises(InputError, match=rf"^rig 'bad'.*({message})"):
            asked()


def test_what_is_no_rig_file_cannot_be_imported_or_has_a_name_that_is_taken(tmp_path):
    written(tmp_path / "a" / "odd_rigs.py", "NONE = 3\n")
    points = (
        "none = odd_rigs:NONE\ngone = nowhere:X\n../up = odd_rigs:NONE\nhinge = odd_rigs:NONE\nmine.xml = odd_rigs:NONE"
    )
    installed(tmp_path / "a", "odd-rigs", points, "imubench.rigs")
    offering(tmp_path / "b", package="one-rig", twice=BODY.format(more=""))
    offering(tmp_path / "c", package="two-rig", twice=BODY.format(more=""))
    assert list(known_rigs()) == [*RIG_SUMMARIES, "none", "gone", "twice"]
    assert known_rigs()["hinge"] == RIG_SUMMARIES["hinge"] and rig_key("hinge") == ""
    assert not is_rig("mine.xml") and not is_rig("../up")
    for rig, message in (
        ("none", "rig 'none': expected a RigFile in odd_rigs:NONE, got int"),
        ("gone", "rig 'gone': nowhere: expected an installed module, got none called 'nowhere'"),
        ("twice", "rig 'twice': expected one package to offer it, got package one-rig 1.2, package two-rig 1.2"),
        ("../up", "unknown rig '../up'; known: hinge, pendulum, free, none, gone, twice"),
    ):
        with pytest.raises(InputError, match=re.escape(message)):
            Recording("r", rig, (still(),))


def still() -> Imu:
    return Imu("imu1", np.arange(3.0), np.zeros((3, 3)), np.full((3, 3), 5.7), 1.0)


def test_a_recording_of_a_rig_that_is_gone_says_so(knee, tmp_path):
    assert here("run", "knee-hand", "--duration", "5", "--out", "played").code == 0
    (tmp_path / "site" / "their_rigs-1.2.dist-info" / "entry_points.txt").unlink()
    installed(tmp_path / "site", "their-rigs", "", "imubench.rigs", version="1.3")
    sys.path.append(str(tmp_path))  # Python looks anew
    done = here("estimate", "seel2012", "played/recording", "--out", "again")
    assert done.code == 2
    assert "unknown rig 'knee'; known: hinge, pendulum, free" in done.err


SPEC = "seconds = 5\nrecordings_per_rig = 1\n[[rig]]\nfamily = 'knee'\n"


def test_datasets_have_it_as_its_file_has_it(knee):
    text = SPEC + "[encoder]\n[[pose]]\nsegment = 'segment2'\n[[effect]]\nname = 'soft_mount'\nfrequency = 12\n"
    Path("spec.toml").write_text(text)
    done = here("generate", "spec.toml", "--count", "2", "--seed", "1", "--workers", "1", "--out", "data")
    assert done.code == 0, done.err
    manifest = json.loads(Path("data/manifest.json").read_text())
    assert manifest["rig_files"] == {"knee": rig_key("knee")}
    assert here("estimate", "olsson2020", "data#1", "--out", "answer").code == 0
    with pytest.raises(
        InputError, match=r"rig\[0\]\.segment_length: expected none of the rig knee, whose file says it"
    ):
        parse_spec({"spec.toml": (SPEC + "segment_length = 0.3\n").encode()})


CLAIM = """
estimator = "seel2012"
scenario = "mine"
[scenarios.mine]
seconds = 5
[[scenarios.mine.rig]]
family = "knee"
[claim.axis]
figure = "best_pairing_rmsae"
at_most = "3 deg"
[claim.named]
scenario = "knee-hand"
figure = "best_pairing_rmsae"
at_most = "3 deg"
"""


def test_claims_are_decided_anew_when_the_rig_changes(knee, tmp_path):
    Path("claims.toml").write_text(CLAIM)
    before = [claim.scenario.key for claim in load_claims(Path("claims.toml"))]
    assert before == [claim.scenario.key for claim in load_claims(Path("claims.toml"))]
    del sys.modules["their_rigs"]
    written(tmp_path / "site" / "their_rigs.py", THEIRS.replace('mass="3"', 'mass="3.5"'))
    after = [claim.scenario.key for claim in load_claims(Path("claims.toml"))]
    assert all(a != b for a, b in zip(before, after, strict=True))


def test_it_is_swept(knee):
    axis = "[[axis]]\nparameter = 'effect.skin_sliding.twist'\nvalues = [0, 0.2]\n"
    effect = "[[effect]]\nname = 'skin_sliding'\nat = 'imu2'\nslide = 0\ntwist = 0.1\n"
    Path("sweep.toml").write_text(
        f"seconds = 5\nrecordings = 2\nlimit_deg = 3\n[[rig]]\nfamily = 'knee'\n{effect}{axis}"
    )
    done = here("sweep", "sweep.toml", "--estimator", "seel2012", "--workers", "0", "--out", "out")
    assert done.code == 0, done.err
    with Path("out/sweep.csv").open() as file:
        clean, slid = (float(row["value"]) for row in csv.DictReader(file))
    assert clean < 1 < slid  # deg: nothing but noise, and a sensor that turns by a fifth of the angle


@pytest.mark.long
def test_what_was_left_out_of_it_is_found(knee):
    """A sensor that sits 3 cm from where its model has it: the law goes through segment, joint and mount."""
    rng = np.random.default_rng(2)
    white = ImuProfile("white", 50.0, ChannelProfile(noise_std=0.004), ChannelProfile(noise_std=0.02))
    rig = standard_rig("knee")
    truth = play(rig, hand_motion(rng, 8.0), 8.0, 500.0)
    mounts = {f"imu{i + 1}": DeclaredMount(m.position, m.quaternion, 1e-3, 5e-3) for i, m in enumerate(rig.mounts)}
    moved = np.array([0.03, 0.0, 0.0])  # m
    mounts["imu2"] = replace(mounts["imu2"], position=mounts["imu2"].position - moved)
    diagnosis, _ = diagnose(observe(truth, white, rng, "knee", Declared(mounts)))
    (first, *others) = diagnosis.findings
    assert (first.effect, first.at) == ("mount_pose", "imu2") and not others
    shift = first.parameters["translation"]
    assert np.all(np.abs(shift.value - moved) < 4 * shift.std)  # one axis in 16,000 is farther off by chance
