"""Estimators from outside: a file, a module, an entry point; a bad one is one line."""

import pickle
import re
import sys
import tomllib
from importlib import invalidate_caches
from pathlib import Path
from textwrap import dedent

import numpy as np
import pytest

from imubench.entry_points import ESTIMATORS as ESTIMATORS_OF_PACKAGES
from imubench.errors import InputError
from imubench.estimate import AnswerError, Estimate
from imubench.estimators import ESTIMATORS, Estimator
from imubench.plugins import FORMS, find_estimator, is_outside, known_estimators
from imubench.recording import Imu, Recording
from imubench.run import simulate

MINE = """
    '''Axes by the largest rates.'''
    import numpy as np
    from imubench.estimate import Estimate

    def estimate(recording):
        '''Return the direction of the largest rate of each IMU.'''
        rates = [imu.gyro[np.argmax(np.linalg.norm(imu.gyro, axis=1))] for imu in recording.imus]
        axes = np.stack(rates) / np.linalg.norm(rates, axis=1, keepdims=True)
        return Estimate("joint_axis", "whatever", axes, None, "not worked out", pairing="unknown")

    def two(recording, more): ...

    number = 3
"""


@pytest.fixture(autouse=True)
def imports_as_before(tmp_path_factory):
    """Forget the modules that tests wrote; the others stay: two copies of one package do not know each other."""
    path, modules = list(sys.path), set(sys.modules)
    yield
    sys.path[:] = path
    for name in set(sys.modules) - modules:
        if str(getattr(sys.modules[name], "__file__", "")).startswith(str(tmp_path_factory.getbasetemp())):
            del sys.modules[name]


@pytest.fixture
def recording() -> Recording:
    rng = np.random.default_rng(0)
    time = np.arange(50) / 100
    imus = tuple(Imu(f"imu{i}", time, rng.normal(size=(50, 3)), rng.normal(size=(50, 3)), 100.0) for i in (1, 2))
    return Recording("r", "hinge", imus)


def written(path: Path, text: str = MINE) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(dedent(text))
    return path


def installed(folder: Path, name: str, points: str, group: str = "imubench.estimators", version: str = "1.2") -> None:
    """Make a folder look like one into which a package was installed, and have Python look into it."""
    info = folder / f"{name.replace('-', '_')}-{version}.dist-info"
    written(info / "METADATA", f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n")
    written(info / "entry_points.txt", f"[{group}]\n{points}\n")
    if str(folder) not in sys.path:
        sys.path.append(str(folder))
    invalidate_caches()


def expected_axes(recording: Recording) -> np.ndarray:
    largest = [max(imu.gyro, key=np.linalg.norm) for imu in recording.imus]
    return np.stack([x / np.linalg.norm(x) for x in largest])


def test_a_file_a_module_and_an_entry_point_are_the_same_estimator(tmp_path, recording, monkeypatch):
    path = written(tmp_path / "elsewhere" / "mine.py")
    written(tmp_path / "here" / "mine_beside.py")
    written(tmp_path / "site" / "mine_package" / "__init__.py")
    installed(tmp_path / "site", "mine-package", "largest = mine_package:estimate")
    monkeypatch.chdir(tmp_path / "here")
    for spec in (f"{path}:estimate", "mine_beside:estimate", "mine_package:estimate", "largest"):
        found = find_estimator(spec)
        assert (found.name, found.quantity, found.imus) == (spec, None, 0)
        assert found.summary == "Return the direction of the largest rate of each IMU."
        assert is_outside(found)
        for one in (found, pickle.loads(pickle.dumps(found))):  # as it reaches another process
            answer = one.estimate(recording)
            assert (answer.estimator, answer.quantity, answer.pairing) == (spec, "joint_axis", "unknown")
            np.testing.assert_array_equal(answer.value, expected_axes(recording))


def test_our_own_are_found_by_name_and_are_never_anothers(tmp_path):
    written(tmp_path / "taken_name.py")
    installed(tmp_path, "taken-name", "olsson2020 = taken_name:estimate")
    assert find_estimator("olsson2020") is ESTIMATORS["olsson2020"]
    assert known_estimators()["olsson2020"] is ESTIMATORS["olsson2020"]
    assert not is_outside(find_estimator("seel2012"))


def test_a_file_may_import_from_beside_itself_and_is_run_once(tmp_path, recording):
    written(tmp_path / "beside_mine.py", "RUNS = []\n")
    path = written(tmp_path / "mine.py", "import beside_mine\nbeside_mine.RUNS.append(1)\n" + dedent(MINE))
    for _ in range(2):
        find_estimator(f"{path}:estimate").estimate(recording)
    assert sys.modules["beside_mine"].RUNS == [1]


def test_an_estimator_stays_what_it_was_when_its_file_changes(tmp_path, recording):
    path = written(tmp_path / "mine.py")
    before = find_estimator(f"{path}:estimate")
    path.write_text(path.read_text().replace("argmax", "argmin"))
    assert not np.allclose(find_estimator(f"{path}:estimate").estimate(recording).value, expected_axes(recording))
    np.testing.assert_array_equal(before.estimate(recording).value, expected_axes(recording))
    np.testing.assert_array_equal(
        pickle.loads(pickle.dumps(before)).estimate(recording).value, expected_axes(recording)
    )


def test_an_estimator_object_says_all_of_itself(tmp_path, recording):
    more = "from imubench.estimators import Estimator\nMINE = Estimator('m', 'mine', 'joint_axis', 2, estimate, 'me')\n"
    path = written(tmp_path / "mine.py", dedent(MINE) + more)
    found = find_estimator(f"{path}:MINE")
    assert isinstance(found, Estimator)
    assert (found.name, found.summary, found.quantity, found.imus) == (f"{path}:MINE", "mine", "joint_axis", 2)
    assert found.estimate(recording).estimator == f"{path}:MINE"


@pytest.mark.parametrize(
    ("returned", "quantity", "shape"),
    [
        ("np.eye(3)[:2]", "joint_axis", (2, 3)),
        ("[[1, 0, 0], [0, 1, 0]]", "joint_axis", (2, 3)),
        ("np.ones((2, 3))", "joint_vector", (2, 3)),
        ("[0.1, 0, 0]", "joint_vector", (1, 3)),
    ],
)
def test_a_plain_array_is_an_estimate_of_what_its_function_says(tmp_path, recording, returned, quantity, shape):
    text = f"import numpy as np\ndef f(recording):\n    return {returned}\nf.quantity, f.imus = '{quantity}', 2\n"
    found = find_estimator(f"{written(tmp_path / 'mine.py', text)}:f")
    assert (found.quantity, found.imus) == (quantity, 2)
    answer = found.estimate(recording)
    assert isinstance(answer, Estimate)
    assert (answer.quantity, answer.value.shape, answer.covariance) == (quantity, shape, None)


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("return None", "expected an Estimate, got None"),
        ("return [[1, 0, 0], [0, 1, 0]]", "expected an Estimate, got list; for an array set function.quantity"),
        ("return [[1, 0], [0, 1, 0]]\nf.quantity = 'joint_axis'", r"expected an array \(m, 3\)"),
        ("return [[1, 0, 0], [2, 0, 0]]\nf.quantity = 'joint_axis'", "expected unit vectors"),
        ("return [[1, 0, 0], [float('nan')] * 3]\nf.quantity = 'joint_axis'", "expected finite numbers"),
        ("return 'axis'\nf.quantity = 'joint_vector'", "expected numbers"),
    ],
)
def test_an_answer_that_is_no_estimate(tmp_path, recording, body, message):
    path = written(tmp_path / "mine.py", f"def f(recording):\n    {body}\n")
    with pytest.raises(AnswerError, match=message):
        find_estimator(f"{path}:f").estimate(recording)


@pytest.mark.parametrize(
    ("text", "function", "message"),
    [
        ("def f(recording):\n    return (\n", "f", r"mine.py, line 2: expected Python, got: "),
        ("\0", "f", "mine.py.*: expected Python, got: "),
        (MINE, "estimates", r"unknown function in .*mine.py 'estimates'; known: .*did you mean 'estimate'\?"),
        (MINE, "number", "mine.py:number: expected a function of a recording or an Estimator, got 3"),
        (MINE, "two", r"mine.py:two: expected a function of one recording, got \(recording, more\)"),
        ("1 / 0", "f", r"expected a file that can be imported, got ZeroDivisionError: .* \(mine.py, line 1\)"),
        ("import sys\nsys.exit(3)", "f", r"expected a file that can be imported, got SystemExit: 3"),
        ("import nothing_of_that_name", "f", "expected a file that can be imported, got ModuleNotFoundError"),
        (MINE + "\n    estimate.quantity = 'axis'", "estimate", "unknown quantity of .*mine.py:estimate 'axis'"),
        (MINE + "\n    estimate.imus = 'two'", "estimate", "mine.py:estimate.imus: expected a number of IMUs"),
    ],
)
def test_a_bad_file_is_one_line(tmp_path, text, function, message):
    with pytest.raises(InputError, match=message) as raised:
        find_estimator(f"{written(tmp_path / 'mine.py', text)}:{function}")
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        ("olsen2020", r"unknown estimator 'olsen2020'; known: olsson2020, .*did you mean 'olsson2020'\?"),
        ("nowhere.py:estimate", "nowhere.py: expected a file, got nothing of that name"),
        ("nowhere.py", "expected a function as well, as in nowhere.py:estimate"),
        ("nowhere.at.all:estimate", "nowhere.at.all: expected an installed module, got none called 'nowhere'"),
        ("numpy:nothing", "unknown function in numpy 'nothing'"),
        (":f", "expected FILE.py:FUNCTION or PACKAGE.MODULE:FUNCTION"),
        ("numpy:", "expected FILE.py:FUNCTION or PACKAGE.MODULE:FUNCTION"),
        ("..up:f", r"\.\.up: expected a module that can be imported, got "),
    ],
)
def test_a_name_that_leads_nowhere_is_one_line(spec, message):
    with pytest.raises(InputError, match=message):
        find_estimator(spec)


def test_what_is_unknown_is_answered_with_all_that_is_known(tmp_path):
    installed(tmp_path, "other", "theirs = other_package:estimate")
    with pytest.raises(InputError) as raised:
        find_estimator("x")
    assert str(raised.value).endswith(FORMS)
    assert "theirs" in known_estimators()


def test_a_broken_entry_point_breaks_no_other_and_says_so_when_asked_for(tmp_path, recording):
    written(tmp_path / "raising_package.py", "raise RuntimeError('no GPU')\n")
    written(tmp_path / "sound_package.py")
    installed(tmp_path, "broken", "raising = raising_package:f\nmissing = not_there:f\nempty = sound_package")
    installed(tmp_path, "sound", "largest = sound_package:estimate")
    assert {"raising", "missing", "empty", "largest"} <= set(known_estimators())
    assert known_estimators()["raising"].summary == "from package broken 1.2"
    assert find_estimator("largest").estimate(recording).estimator == "largest"
    for name, message in (
        ("raising", "estimator 'raising': raising_package: expected a module .*RuntimeError: no GPU"),
        ("missing", "estimator 'missing': not_there: expected an installed module"),
        ("empty", "estimator 'empty': unknown function in sound_package ''"),
    ):
        with pytest.raises(InputError, match=message):
            find_estimator(name)
        with pytest.raises(InputError, match=message):
            known_estimators()[name].estimate(recording)


def test_a_package_whose_list_cannot_be_read_breaks_no_other(tmp_path, recording):
    written(tmp_path / "sound_too.py")
    installed(tmp_path, "sound-too", "largest = sound_too:estimate")
    installed(tmp_path, "unreadable", "not an entry point at all")
    assert find_estimator("largest").estimate(recording).estimator == "largest"


def test_a_name_that_two_packages_offer_is_neithers(tmp_path):
    written(tmp_path / "both_offer.py")
    installed(tmp_path, "one", "largest = both_offer:estimate")
    installed(tmp_path, "two", "largest = both_offer:two")
    with pytest.raises(InputError, match=r"expected one package to offer it, got package one .*, package two"):
        find_estimator("largest")


DOCS = (Path(__file__).resolve().parent.parent / "docs" / "your-estimator.md").read_text()


@pytest.mark.long
def test_the_page_of_the_docs_works_as_it_stands_there(tmp_path, monkeypatch):
    mine, array, call = re.findall(r"```python\n(.*?)```", DOCS, flags=re.DOTALL)
    monkeypatch.chdir(tmp_path)
    written(tmp_path / "mine.py", mine)
    written(tmp_path / "array.py", array)
    simulated = simulate("hinge-hand", 1)[0]
    answer = find_estimator("array.py:straight_ahead").estimate(simulated)
    np.testing.assert_array_equal(answer.value, [[0, 1, 0]] * 2)
    space: dict[str, object] = {}
    exec(call, space)  # starts a process
    assert isinstance(space["answer"], Estimate)
    np.testing.assert_allclose(space["answer"].value, find_estimator("mine.py:estimate").estimate(simulated).value)
    (table,) = re.findall(r"```toml\n(.*?)```", DOCS, flags=re.DOTALL)
    assert tomllib.loads(table)["project"]["entry-points"][ESTIMATORS_OF_PACKAGES]
