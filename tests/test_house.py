"""The rooms of the diagnosis keep their order and their size, and what is to become less does not become more."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from imubench.effects import EFFECTS
from imubench.models import RIG_FILES
from scripts.house_measures.constants import ambiguous, numeric
from scripts.house_measures.docstrings import past_figures
from scripts.house_measures.effects import effects_named, laws_of_effects, laws_used
from scripts.house_measures.imports import chain, upward
from scripts.house_measures.lengths import too_long
from scripts.house_measures.limits import LIMITS
from scripts.house_measures.limits import measures as measures_of
from scripts.house_measures.rigs import parts_named, rig_branches
from scripts.house_measures.rooms import ROOMS, House

ROOT = Path(__file__).resolve().parent.parent
HOUSE = House()


@pytest.fixture(scope="module")
def measures():
    return measures_of(HOUSE, EFFECTS, laws_of_effects(), RIG_FILES)


@pytest.mark.parametrize("name", list(LIMITS))
def test_every_measure_keeps_its_limit(measures, name):
    count, found = measures[name]
    assert count <= LIMITS[name].now, "\n".join(found)
    assert LIMITS[name].aim <= LIMITS[name].now


@pytest.mark.long
def test_the_script_runs_from_any_folder_and_lists_what_a_measure_counts(tmp_path):
    said = subprocess.run(
        [sys.executable, ROOT / "scripts" / "house.py", "chain"], cwd=tmp_path, capture_output=True, text=True
    )
    assert said.returncode == 0, said.stderr
    assert all(f"\n{name} " in said.stdout for name in LIMITS)
    assert re.findall(r"^    (\S+)$", said.stdout, re.M) == chain(HOUSE)


def test_every_room_has_modules_and_one_line_that_says_what_it_holds():
    assert all(HOUSE.rooms().values())
    for name, module in HOUSE.modules.items():
        if module.is_package:
            first = module.path.read_text().splitlines()[0]
            assert first.startswith('"""') and first.removesuffix('"""').endswith("."), name


def test_contributing_lists_the_rooms_in_their_order():
    text = (ROOT / "CONTRIBUTING.md").read_text()
    part = text[text.index("## The rooms of the diagnosis") :]
    rows = re.findall(r"^\| `([a-z_./]+)` \|", part, re.M)
    folders = [room.replace("diagnosis/", "").rstrip("/").replace("/", ".") for room in rows]
    assert tuple(folders) == ROOMS


def planted(root: Path, files: dict[str, str]) -> House:
    """Return a house of some files by their path."""
    for name, text in files.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text)
    return House(root)


def test_an_import_from_a_higher_room_is_seen_wherever_it_stands(tmp_path):
    house = planted(
        tmp_path,
        {
            "diagnosis/__init__.py": '"""."""',
            "diagnosis/result.py": "def f():\n    from imubench.diagnosis.solve.fit import g",
            "diagnosis/solve/__init__.py": '"""."""',
            "diagnosis/solve/fit.py": "import imubench.diagnosis.pipeline",
            "diagnosis/pipeline.py": "from imubench.diagnosis import result\nfrom imubench.diagnosis.solve import fit",
            "diagnosis/search/moves/add.py": "from imubench.diagnosis.search import state",
            "diagnosis/search/state.py": "from .moves import add",
            "correction/played.py": "from imubench.diagnosis.search.moves.add import x",
        },
    )
    assert sorted(upward(house)) == [
        "diagnosis.result imports diagnosis.solve.fit",
        "diagnosis.search.moves.add imports diagnosis.search.state",
        "diagnosis.solve.fit imports diagnosis.pipeline",
    ]
    with pytest.raises(ValueError, match="in a circle: "):
        chain(house)


def test_what_a_package_hands_on_counts_as_an_import_of_it(tmp_path):
    house = planted(
        tmp_path,
        {
            "diagnosis/report/__init__.py": "from imubench.diagnosis.report.page import Paths",
            "diagnosis/report/page.py": "class Paths: ...",
            "diagnosis/search/state.py": "from imubench.diagnosis.report import Paths",
        },
    )
    assert upward(house) == ["diagnosis.search.state imports diagnosis.report"]
    assert chain(house) == ["diagnosis.search.state", "diagnosis.report", "diagnosis.report.page"]


def test_a_room_that_has_no_place_is_refused(tmp_path):
    with pytest.raises(ValueError, match="unknown room 'helpers'; known: pipeline, report, "):
        planted(tmp_path, {"diagnosis/helpers/a.py": ""}).rooms()


def test_the_longest_chain_is_found(tmp_path):
    files = {f"diagnosis/solve/m{i}.py": f"from imubench.diagnosis.solve.m{i + 1} import x" for i in range(5)}
    files |= {"diagnosis/solve/m5.py": "x = 1", "diagnosis/solve/other.py": "from imubench.diagnosis.solve.m4 import x"}
    assert chain(planted(tmp_path, files)) == [f"diagnosis.solve.m{i}" for i in range(6)]


def test_constants_are_counted_by_what_is_written(tmp_path):
    house = planted(
        tmp_path,
        {
            "diagnosis/solve/a.py": "LEAST, MOST = 1, 2\nNAMES = ('x',)\nON = True\nTABLE = {'a': 3.0}\nlow = 4\n",
            "diagnosis/solve/b.py": "LEAST: float = 1\nMOST = 3\nHALF = MOST / 2\n\ndef f():\n    LATER = 5\n",
        },
    )
    assert sorted(numeric(house)) == [
        "diagnosis.solve.a.LEAST",
        "diagnosis.solve.a.MOST",
        "diagnosis.solve.a.TABLE",
        "diagnosis.solve.b.HALF",
        "diagnosis.solve.b.LEAST",
        "diagnosis.solve.b.MOST",
    ]
    assert ambiguous(house) == ["MOST: 2 values, in diagnosis.solve.a, diagnosis.solve.b"]


def test_effects_are_seen_by_their_names_but_where_people_read_them(tmp_path):
    house = planted(
        tmp_path,
        {
            "diagnosis/search/a.py": '"""low_pass"""\nif name == "low_pass":\n    x = "passes", f"low_pass@{at}"\n',
            "diagnosis/report/words.py": 'WORDS = {"low_pass": "a filter"}',
        },
    )
    assert effects_named(house, {"low_pass": None}) == [
        "diagnosis.search.a:1: low_pass",
        "diagnosis.search.a:2: low_pass",
        "diagnosis.search.a:3: low_pass@",
    ]


def test_laws_of_effects_are_seen_where_they_are_used(tmp_path):
    house = planted(
        tmp_path,
        {
            "diagnosis/search/a.py": "from imubench.effects.bandwidth import LowPass as Filter, delay_of\n"
            "from imubench.effects import EFFECTS\nif isinstance(x, Filter):\n    y = delay_of(EFFECTS)\n",
            "diagnosis/search/b.py": "from imubench.effects.effect import Effect\nx: Effect\n",
        },
    )
    assert {"LowPass", "TimeOffset", "Sprung"} <= laws_of_effects()
    assert not {"Effect", "EFFECTS", "delay_of"} & laws_of_effects()
    assert laws_used(house, laws_of_effects()) == ["diagnosis.search.a:3: LowPass"]


def test_branches_on_a_rigs_name_are_seen_outside_of_where_rigs_live(tmp_path):
    text = (
        'A = {"hinge": 1, "free": 2}\n'
        'B = {("hinge", "imu1"): 3}\n'
        "def f(r, kind):\n"
        '    if r.rig == "hinge" or "pendulum" != r:\n'
        "        return r.family != USUAL\n"
        '    if r.rig in ("hinge", "free"):\n'
        '        return kind == "free" or r.base == "free" or r.rig in RIGS or r.rig == other.rig\n'
        "    match r:\n"
        '        case "free":\n'
        '            return Recording("hinge", kind=("free", "fixed"), words={"free": 1, "springy": 2})\n'
        'rigs = ("hinge",)\n'
    )
    house = planted(
        tmp_path, {"sim/a.py": text, "models/b.py": text, "tests/c.py": text, ".venv/d.py": text, "diagnosis/e.py": ""}
    )
    found = rig_branches(house.root, {"hinge", "pendulum", "free"})
    lines = sorted(int(line.removeprefix("sim/a.py:")) for line in found)
    assert lines == [1, 2, 4, 4, 5, 6, 9, 11]


def test_segments_and_imus_are_seen_by_their_names(tmp_path):
    house = planted(tmp_path, {"diagnosis/a.py": '"""imu1"""\nx = ("imu2", "segment1", "imu", "the imu1")'})
    assert parts_named(house) == ["diagnosis.a:1: imu1", "diagnosis.a:2: imu2", "diagnosis.a:2: segment1"]


def test_a_docstring_that_tells_of_a_run_is_told_from_one_that_says_what_is_computed(tmp_path):
    house = planted(
        tmp_path,
        {
            "diagnosis/noise/a.py": '"""A filter of 24 Hz was one of 36 Hz once its law had settled."""\n'
            'def f():\n    """Return the 2 numbers (k,) of a fit. It was solved before."""\n'
            'def g():\n    """Return what a fit gained."""\n'
            'def h():\n    """Return half.\n\n    Three pendulums had filters of 30 to 134 nat.\n    """\n'
        },
    )
    assert past_figures(house) == ["diagnosis.noise.a:", "diagnosis.noise.a:h"]


def test_a_module_of_401_lines_is_too_long(tmp_path):
    house = planted(tmp_path, {"diagnosis/a.py": "x = 1\n" * 400, "diagnosis/b.py": "x = 1\n" * 401})
    assert too_long(house.root) == ["diagnosis/b.py"]


def test_a_module_that_is_too_long_is_counted_wherever_it_lies(tmp_path):
    folders = (
        "diagnosis/solve",
        "effects",
        "sim",
        "imubench/commands",
        "tests/regressions",
        "scripts",
        "benchmarks/real",
    )
    counted = sorted(["setup.py", *(f"{folder}/a.py" for folder in folders)])
    not_ours = [".venv/lib/a.py", "build/lib/a.py"]
    house = planted(tmp_path, dict.fromkeys([*counted, *not_ours], "x = 1\n" * 401))
    count, found = measures_of(house, {}, (), ())["modules over 400 lines"]
    assert (count, sorted(found)) == (len(counted), counted)
