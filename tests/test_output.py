"""What lies at --out and in the inputs is safe: refused before the work begins, written nowhere else.

Lost or written elsewhere, as it was once found:
1. --out that is, contains, or lies in the input deleted the recording;
2. `prove --added` wrote over any file that a recording.toml named;
3. `export` wrote outside --out where a dataset's row was named ../../x;
4. the second of two `prove` into one --out deleted the first one's work;
5. a foreign --out was refused only after the work was done.
"""

import hashlib
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from imubench.atomic import atomic_directory
from imubench.dataset.generate import generate
from imubench.dataset.shard import Job
from imubench.errors import InputError
from imubench.proof.case import make_case
from tests.command import here
from tests.test_main import one_line

SPEC = "name = 'small'\nseconds = 2\n[[rig]]\nfamily = 'hinge'\n"
SWEEP = SPEC + "[[axis]]\nparameter = 'motion.bandwidth'\nvalues = [1, 2]\n"
SWEEP = f"recordings = 1\nlimit_deg = 2\n{SWEEP}"
CLAIMS = "estimator = 'seel2012'\nscenario = 'hinge-hand'\n[claim.a]\nfigure = 'maxae'\nat_most = '2 deg'\n"
IMU = "time,gyr_x,gyr_y,gyr_z,acc_x,acc_y,acc_z\n0.00,0,0,0,0,0,9.81\n0.01,0,0,0,0,0,9.81\n"


def everything(folder: Path) -> dict[str, object]:
    """Return what is below a folder: links by where they lead, files by content and time of change."""
    found: dict[str, object] = {}
    for path in sorted(folder.rglob("*")):
        name = path.relative_to(folder).as_posix()
        if path.is_symlink():
            found[name] = path.readlink()
        else:
            found[name] = (path.read_bytes(), path.stat().st_mtime_ns) if path.is_file() else "a folder"
    return found


@pytest.fixture(scope="module")
def given(tmp_path_factory):
    """Inputs of every kind, each in a folder of its own in `home`."""
    home = tmp_path_factory.mktemp("given") / "home"
    make_case(home / "recording", "hinge", [], 5, seconds=2.0)
    (home / "diagnosis").mkdir()
    (home / "diagnosis" / "diagnosis.json").write_text("{}")
    (home / "table").mkdir()
    (home / "table" / "imu1.csv").write_text(IMU)
    (home / "spec").mkdir()
    (home / "spec" / "spec.toml").write_text(SPEC)
    (home / "grid").mkdir()
    (home / "grid" / "sweep.toml").write_text(SWEEP)
    generate(Job({"spec.toml": SPEC.encode()}, 3, 1, str(home / "dataset")), workers=0)
    (home / "model").mkdir()
    (home / "model" / "imus.toml").write_text("format = 1\n")
    (home / "claims").mkdir()
    (home / "claims" / "claims.toml").write_text(CLAIMS)
    (home / "real").mkdir()
    make_case(home / "real" / "monday", "hinge", [], 5, seconds=2.0)
    return home


@pytest.fixture
def home(given, tmp_path):
    return shutil.copytree(given, tmp_path / "home")


READING = {  # the words before --out, and the folder of the input
    "estimate": (("estimate", "seel2012", "recording"), "recording"),
    "estimate --with": (("estimate", "seel2012", "real/monday", "--with", "diagnosis"), "diagnosis"),
    "estimate --with, a file": (
        ("estimate", "seel2012", "real/monday", "--with", "diagnosis/diagnosis.json"),
        "diagnosis",
    ),
    "diagnose": (("diagnose", "recording"), "recording"),
    "convert": (("convert", "csv", "table/imu1.csv", "--option", "rig=free"), "table"),
    "run": (("run", "model"), "model"),
    "export": (("export", "qmt", "dataset"), "dataset"),
    "prove --added": (("prove", "--added", "real", "--cases", "1"), "real"),
    "prove --real": (("prove", "--real", "real"), "real"),
    "generate": (("generate", "spec/spec.toml", "--count", "1"), "spec"),
    "sweep": (("sweep", "grid/sweep.toml", "--estimator", "seel2012"), "grid"),
    "check": (("check", "claims/claims.toml"), "claims"),
}


WAYS = ("the folder", "one above", "one inside", "a link to it", "through a link")
OF_A_FILE = ("estimate --with, a file", "convert", "generate", "sweep", "check")
"""Whose input is a file: a new folder beside it overlaps nothing."""


@pytest.mark.parametrize(
    ("command", "way"), [(c, w) for c in READING for w in WAYS if not (c in OF_A_FILE and w == "one inside")]
)
def test_an_output_that_overlaps_an_input_is_refused_and_nothing_is_touched(command, way, home, monkeypatch):
    """1: --out is the input, holds it or lies in it, links followed, in every command that reads something."""
    words, folder = READING[command]
    monkeypatch.chdir(home)
    out = {"the folder": folder, "one above": "../home", "one inside": f"{folder}/new/deep"}.get(way, "link")
    if way == "a link to it":
        (home / "link").symlink_to(folder)
    if way == "through a link":  # the output is where it is said to be, the input is named by a link
        (home / "link").symlink_to(folder)
        words, out = tuple(re.sub(rf"^{folder}\b", "link", word) for word in words), folder
    if way == "one above":
        monkeypatch.chdir(home.parent)
        words, out = tuple(f"home/{w}" if w.startswith((folder, "real", "recording")) else w for w in words), "home"
    before = everything(home.parent)
    done = here(*words, "--out", out)
    assert done.code == 2
    assert everything(home.parent) == before
    assert "expected a place for the output apart from the input" in one_line(done.err)


def test_an_input_that_is_reached_by_a_link_in_the_input_is_apart_too(home, monkeypatch):
    """1: the recording's table is a link into the folder that is written."""
    monkeypatch.chdir(home)
    shutil.move("recording/imu1.csv", "elsewhere.csv")
    with atomic_directory(home / "out") as folder:
        shutil.copy("elsewhere.csv", folder / "imu1.csv")
    (home / "recording" / "imu1.csv").symlink_to("../out/imu1.csv")
    before = everything(home)
    done = here("estimate", "seel2012", "recording", "--out", "out")
    assert done.code == 2
    assert "apart from the input" in one_line(done.err)
    assert everything(home) == before


@pytest.mark.parametrize("absolute", (True, False))
def test_added_effects_are_written_into_the_copy_alone(absolute, home, tmp_path, monkeypatch):
    """2: a recording.toml that names a file elsewhere, absolute or by .. ."""
    monkeypatch.chdir(home)
    victim = tmp_path / "thesis.csv"
    shutil.copy("real/monday/imu1.csv", victim)
    table = home / "real" / "monday" / "recording.toml"
    table.write_text(table.read_text().replace("imu1.csv", str(victim) if absolute else "../../../thesis.csv"))
    before = everything(tmp_path)
    done = here("prove", "--added", "real", "--cases", "1", "--seed", "1", "--workers", "1", "--out", "out")
    assert done.code == 2
    assert "thesis.csv" in one_line(done.err)
    assert {k: v for k, v in everything(tmp_path).items() if not k.startswith("home/.out.")} == before


@pytest.mark.parametrize("form", ("format1", "qmt", "opensim", "ring"))
def test_an_export_writes_into_its_folder_alone(form, home, monkeypatch):
    """3: a row of a dataset that is named as a path."""
    file = next((home / "dataset" / "recordings").glob("*-00000.parquet"))
    rows = pq.read_table(file)
    assert rows.schema.get_field_index("name") >= 0
    named = pa.array(["../../x"] * len(rows))
    pq.write_table(rows.set_column(rows.schema.get_field_index("name"), "name", named), file)
    manifest = home / "dataset" / "manifest.json"
    table = json.loads(manifest.read_text())
    table["files"][f"recordings/{file.name}"] = {
        "sha256": hashlib.sha256(file.read_bytes()).hexdigest(),
        "bytes": file.stat().st_size,
    }
    manifest.write_text(json.dumps(table))
    (home / "a" / "b").mkdir(parents=True)
    monkeypatch.chdir(home)
    before = everything(home.parent)
    done = here("export", form, "dataset", "--out", "a/b/out")
    assert done.code == 2
    assert "'../../x'" in one_line(done.err)
    assert everything(home.parent) == before


WORKING = {  # the words before --out, and the function that begins the work
    "list": (("list",), "imubench.answers.write_json"),
    "run": (("run", "hinge-hand"), "imubench.run.simulate"),
    "estimate": (("estimate", "seel2012", "recording"), "imubench.run.read"),
    "diagnose": (("diagnose", "recording"), "imubench.diagnosis.on_disk.read"),
    "convert": (("convert", "csv", "table/imu1.csv", "--option", "rig=free"), "imubench.convert.csv.read_columns"),
    "reproduce": (("reproduce", "arve", "--quick"), "imubench.reproduce.reproduce.run_parts"),
    "generate": (("generate", "spec/spec.toml", "--count", "1"), "imubench.dataset.generate._made"),
    "sweep": (("sweep", "grid/sweep.toml", "--estimator", "seel2012"), "imubench.sweeps.run._outcomes"),
    "check": (("check", "claims/claims.toml", "--workers", "1"), "imubench.commands.work.check.check"),
    "export": (("export", "qmt", "dataset"), "imubench.commands.work.generate.indices"),
    "prove": (("prove", "--cases", "1"), "imubench.trials.prove.make_cases"),
    "prove --real": (("prove", "--real", "real"), "imubench.trials.prove.publish_sealed"),
}


@pytest.mark.parametrize("command", WORKING)
def test_a_foreign_output_is_refused_before_any_work(command, home, monkeypatch):
    """5: nothing is begun, nothing is touched."""
    words, work = WORKING[command]
    monkeypatch.chdir(home)

    def begun(*_: object, **__: object) -> None:
        raise AssertionError("the work has begun")

    monkeypatch.setattr(work, begun)
    control = here(*words, "--out", "new")
    assert control.code == 70, "the test knows where the work begins"
    Path(one_line(control.err).rpartition(" ")[2]).unlink()
    (home / "out").mkdir()
    (home / "out" / "thesis.txt").write_text("years of work")
    before = everything(home)
    done = here(*words, "--out", "out")
    assert done.code == 2
    assert "thesis.txt'" in one_line(done.err)
    assert everything(home) == before


HOLDING = """
import sys
from pathlib import Path
from imubench.lock import locked
with locked(Path(sys.argv[1]), "out"):
    print("held", flush=True)
    sys.stdin.read()
"""


@pytest.mark.parametrize("command", WORKING)
def test_an_output_that_another_run_writes_is_refused_before_any_work(command, home, monkeypatch):
    """4: the message names the process; what the other run has is left alone."""
    words, _ = WORKING[command]
    monkeypatch.chdir(home)
    lock = home / ("out/.generate/lock" if command == "generate" else ".out.lock")
    lock.parent.mkdir(parents=True, exist_ok=True)
    other = subprocess.Popen([sys.executable, "-c", HOLDING, str(lock)], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    assert other.stdin is not None and other.stdout is not None
    assert other.stdout.readline() == b"held\n"
    before = everything(home)
    done = here(*words, "--out", "out")
    after = everything(home)
    other.communicate(timeout=60)
    assert done.code == 2
    assert after == before
    assert one_line(done.err).endswith(f"got one in use by process {other.pid}")


def test_two_parts_of_one_process_do_not_write_to_one_folder(tmp_path):
    with (
        atomic_directory(tmp_path / "out") as folder,
        pytest.raises(InputError, match="no other run writes to"),
        atomic_directory(tmp_path / "out"),
    ):
        raise AssertionError(folder)
    assert (tmp_path / "out").is_dir()
