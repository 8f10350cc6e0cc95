"""What the commands say of themselves, and estimators from outside in them."""

import json
import re
import shlex
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import typer

from imubench.cli import COMMANDS, app
from imubench.format1 import write_recording
from imubench.run import simulate
from tests.command import here, imubench
from tests.test_plugins import imports_as_before, installed, written  # noqa: F401

QMT = """
    import numpy as np
    import qmt
    from imubench.estimate import Estimate
    from imubench.paired import paired

    def hinge(recording):
        '''Return the hinge axis by qmt alone.'''
        both = paired(recording)
        arrays = [np.array(x) for x in (both.accel1, both.accel2, both.gyro1, both.gyro2)]
        found = qmt.jointAxisEstHingeOlsson(*arrays, {"x0": np.zeros(4), "quiet": True})
        axes = np.stack([np.ravel(axis) for axis in found[:2]])
        return Estimate("joint_axis", "qmt", axes, None, "qmt reports none", pairing="unknown")

    def broken(recording):
        return [[0.0, 0.0, float("nan")]] * 2
    broken.quantity = "joint_axis"
"""


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("recorded") / "hand"
    folder.mkdir()
    write_recording(simulate("hinge-hand", 3)[0], folder)
    return folder


@pytest.fixture
def outside(tmp_path, monkeypatch) -> dict[str, tuple[str, str]]:
    """Return the specs of qmt's estimator and of a broken one, by each of the three ways."""
    pytest.importorskip("qmt")
    monkeypatch.chdir(tmp_path)
    written(tmp_path / "by_file.py", QMT)
    written(tmp_path / "site" / "by_module.py", QMT)
    written(tmp_path / "site" / "by_package" / "__init__.py", QMT)
    installed(tmp_path / "site", "by-package", "qmt-theirs = by_package:hinge\nbroken-theirs = by_package:broken")
    return {
        "file": ("by_file.py:hinge", "by_file.py:broken"),
        "module": ("by_module:hinge", "by_module:broken"),
        "entry point": ("qmt-theirs", "broken-theirs"),
    }


@pytest.mark.parametrize("way", ["file", "module", "entry point"])
def test_an_estimator_from_outside_takes_its_place_in_estimate(outside, recording, tmp_path, way):
    sound, broken = outside[way]
    ours, theirs = (
        here("estimate", name, recording, "--out", tmp_path / out) for name, out in (("qmt", "a"), (sound, "b"))
    )
    assert (ours.code, theirs.code) == (0, 0), theirs.err
    values = [json.loads((tmp_path / out / "estimate.json").read_text())["value"] for out in ("a", "b")]
    off = np.abs(np.einsum("ij,ij->i", *map(np.array, values)))
    np.testing.assert_allclose(off, 1.0, atol=1e-12)  # the same code on the same samples, but for signs
    failed = here("estimate", broken, recording, "--out", tmp_path / "c")
    assert failed.code == 1
    assert f"{broken} malformed: {broken}.value: expected finite numbers" in failed.out
    content = json.loads((tmp_path / "c" / "estimate.json").read_text())
    assert (content["estimator"], content["status"], "value" in content) == (broken, "malformed", False)


@pytest.mark.long
def test_an_estimator_from_outside_takes_its_place_in_run(outside, tmp_path):
    for sound, broken in outside.values():
        done = here("run", "hinge-hand", "--estimator", sound, "--out", tmp_path / "a")
        assert done.code == 0, done.err
        figures = json.loads((tmp_path / "a" / "score.json").read_text())["figures"]
        assert figures["best_pairing_maxae"]["value"] < np.deg2rad(1.0)  # 0.3 deg of ours on this scenario, with noise
        failed = here("run", "hinge-hand", "--estimator", broken, "--out", tmp_path / "b")
        assert failed.code == 1
        score = json.loads((tmp_path / "b" / "score.json").read_text())
        assert (score["estimator"], score["status"], score["estimate"]) == (broken, "malformed", None)
        assert {"recording", "run.rrd"} <= {p.name for p in (tmp_path / "b").iterdir()}


def test_a_crash_is_told_with_its_place_and_its_trace(recording, tmp_path):
    path = written(tmp_path / "mine.py", "def f(recording):\n    return recording.nothing\n")
    done = here("estimate", f"{path}:f", recording, "--out", tmp_path / "out")
    assert done.code == 1
    assert "crashed: AttributeError: 'Recording' object has no attribute 'nothing' (mine.py, line 2)" in done.out
    trace = (tmp_path / "out" / "failure.txt").read_text().splitlines()
    assert trace[1].endswith('mine.py", line 2, in f')  # the author's own code is the first that it names


@pytest.mark.long
def test_a_hang_is_its_result(recording, tmp_path):
    written(tmp_path / "mine.py", "def f(recording):\n    while True: pass\n")
    words = ("estimate", "mine.py:f", recording, "--time-limit", 0.5, "--out", "out")
    done = imubench(*words, folder=tmp_path, limit=300)
    assert done.returncode == 1, done.stderr
    assert "mine.py:f timed out: no answer after 0.5 s" in done.stdout


def test_outside_estimators_are_listed_and_do_not_make_a_folder_of_their_path(outside, recording, tmp_path):
    listed = here("list", "estimators", "--json")
    names = {e["name"]: e["summary"] for e in json.loads(listed.out)["estimators"]}
    assert names["qmt-theirs"] == "from package by-package 1.2"
    assert here("estimate", tmp_path / "by_file.py:hinge", recording).code == 0
    assert (tmp_path / "runs" / "by_file.py-hinge-hand" / "estimate.json").exists()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (
            ("estimate", "REC", "seel2012"),
            "imubench estimate: expected seel2012 before .*, got them the other way round",
        ),
        (("estimate", "some-dataset#3", "seel2012"), "expected seel2012 before some-dataset#3, got them the other way"),
        (("estimate", "REC", "mine.py:f"), "imubench estimate: expected mine.py:f before .*, got them the other way"),
        (
            ("convert", "REC", "csv", "--out", "x"),
            "imubench convert: expected csv before .*, got them the other way round",
        ),
        (
            ("export", "REC", "qmt", "--out", "x"),
            "imubench export: expected qmt before .*, got them the other way round",
        ),
        (("list", "estimator"), "unknown kind 'estimator'; known: .*; did you mean 'estimators'?"),
        (("estimate", "sel2012", "REC"), "unknown estimator 'sel2012'; .*; did you mean 'seel2012'?"),
    ],
)
def test_a_slip_is_told_with_what_was_meant(recording, words, message):
    done = here(*(recording if word == "REC" else word for word in words))
    assert done.code == 2
    assert re.search(message.replace("?", r"\?"), done.err), done.err
    assert done.err.count("\n") == 1


def test_every_command_has_a_docstring_and_two_examples_or_more():
    commands = typer.main.get_command(app).commands
    assert set(commands) == {c.name for c in COMMANDS}
    for command in COMMANDS:
        assert len(command.examples) >= 2, command.name
        assert (command.function.__doc__ or "").strip(), command.name
        for example in command.examples:
            words = shlex.split(example)
            assert words[:2] == ["imubench", command.name]
            commands[command.name].make_context(command.name, words[2:])  # raises for an option that is not there


def test_a_shell_can_complete_commands():
    done = imubench(
        folder=Path.cwd(), limit=60, _IMUBENCH_COMPLETE="complete_bash", COMP_WORDS="imubench re", COMP_CWORD="1"
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == ["reproduce"]


def test_help_needs_neither_numpy_nor_mujoco():
    script = "import sys, imubench.cli; print([m for m in ('numpy', 'scipy', 'mujoco', 'rerun') if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_a_refusal_needs_neither_the_diagnosis_nor_what_logs(tmp_path):
    """Of bad input one is told at once; and a recording of our rigs is made without MuJoCo."""
    script = (
        "import sys; from pathlib import Path; from imubench.errors import InputError\n"
        "from imubench.recording import Imu, Recording; import numpy as np\n"
        "still = Imu('imu1', np.arange(3.0), np.zeros((3, 3)), np.ones((3, 3)), 1.0)\n"
        "Recording('r', 'hinge', (still,)); early = [m for m in ('mujoco', 'scipy.optimize') if m in sys.modules]\n"
        "from imubench.run import estimate_on_disk\n"
        "try:\n    estimate_on_disk('seel2012', Path('nowhere'), Path('out'))\nexcept InputError as error:\n"
        "    heavy = ('mujoco', 'rerun', 'scipy.signal', 'scipy.stats', 'imubench.diagnosis.problem')\n"
        "    print(early + [m for m in heavy if m in sys.modules], 'nowhere' in str(error))"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True, cwd=tmp_path)
    assert done.stdout.strip() == "[] True"


def test_what_is_listed_imports_no_more_than_it_needs():
    """Rigs need neither NumPy nor MuJoCo; SciPy's filters and distributions are for what computes."""
    script = (
        "import sys; from imubench.listing import KINDS, known; assert KINDS['rigs'](); "
        "early = [m for m in ('numpy', 'scipy', 'mujoco', 'rerun') if m in sys.modules]; known(); "
        "print(early + [m for m in ('scipy.signal', 'scipy.stats', 'rerun') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
