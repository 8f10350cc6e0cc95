"""Formats and scenarios that installed packages offer; estimators are in test_plugins.py."""

import json

import numpy as np
import pytest

from imubench.checks.claim import load_claims
from imubench.convert import CONVERTERS, find_converter, known_converters
from imubench.errors import InputError
from imubench.run import simulate
from imubench.scenarios import SCENARIOS, find_scenario, known_scenarios
from tests.command import here
from tests.test_plugins import imports_as_before, installed, written  # noqa: F401

THEIRS = """
    import numpy as np
    from imubench.convert.converter import Converted, Converter, Option
    from imubench.recording import Imu, Recording
    from imubench.scenarios.hinge import hand_motion
    from imubench.scenarios.scenario import Scenario, prescribed
    from imubench.sim.rigs import hinge, rod

    def convert(source, rate=100.0):
        time = np.arange(50) / rate
        read = np.full((50, 3), float(source.read_text()))
        imu = Imu("imu1", time, read, read + [0, 0, 9.81], rate)
        return [Converted(Recording("theirs", "free", (imu,)), None, "of no licence")]

    def broken(source):
        return 1 / 0

    def wrong(source):
        return "recording"

    def play(rng, seconds, effects):
        rig = hinge(segments=(rod(1.0, (-0.4, 0, 0), (-0.02, 0, 0), 0.03), rod(0.5, (0.02, 0, 0), (0.3, 0, 0), 0.02)))
        return prescribed(rig, hand_motion(rng, seconds), seconds, rng, effects)

    CONVERTER = Converter("theirs", "their files", convert, {"rate": Option("Hz", float)})
    BROKEN = Converter("broken", "", broken)
    WRONG = Converter("wrong", "", wrong)
    ARM = Scenario("their-arm", "a heavy arm", "olsson2020", "xsens_mtw", play, seconds=12.0)
    FAILING = Scenario("failing", "", None, "xsens_mtw", lambda rng, seconds, effects: 1 / 0)
"""


@pytest.fixture
def package(tmp_path):
    written(tmp_path / "site" / "their_things.py", THEIRS)
    points = "theirs = their_things:CONVERTER\nbroken = their_things:BROKEN\nwrong = their_things:WRONG\n"
    points += "no = their_things:play"
    installed(tmp_path / "site", "their-formats", points, "imubench.converters")
    points = "their-arm = their_things:ARM\nfailing = their_things:FAILING\ngone = their_things:GONE"
    installed(tmp_path / "site", "their-scenarios", points, "imubench.scenarios")
    return tmp_path


def test_a_format_of_a_package_is_converted(package, tmp_path):
    (tmp_path / "source").write_text("0.5")
    done = here("convert", "theirs", tmp_path / "source", "--option", "rate=50", "--out", tmp_path / "out")
    assert done.code == 0, done.err
    assert "theirs: of no licence" in done.out
    assert "rate = 50" in (tmp_path / "out" / "recording.toml").read_text()
    assert known_converters()["theirs"] == "from package their-formats 1.2"
    assert find_converter("csv") is CONVERTERS["csv"]
    assert find_converter("theirs").default("rate") == 100.0


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("broken", r"format 'broken': expected it to work, got ZeroDivisionError: .* \(their_things.py, line \d+\)"),
        ("wrong", "format 'wrong': expected a list of Converted, got 'recording'"),
        ("no", "format 'no': expected a Converter in their_things:play, got function"),
        ("theres", "unknown format 'theres'; known: .*; did you mean 'theirs'"),
    ],
)
def test_a_format_that_is_broken_is_one_line(package, tmp_path, name, message):
    with pytest.raises(InputError, match=message):
        find_converter(name)(written(tmp_path / "source", "0.5"))


def test_a_scenario_of_a_package_is_run_with_its_own_rig(package, tmp_path):
    done = here("run", "their-arm", "--out", tmp_path / "out", "--effect", "gyro_bias@imu1:bias=0.02")
    assert done.code == 0, done.err
    score = json.loads((tmp_path / "out" / "score.json").read_text())
    assert score["scenario"] == "their-arm"
    assert score["figures"]["maxae"]["value"] < np.deg2rad(3)  # 12 s of a hand, a bias of a degree a second
    assert known_scenarios()["their-arm"] == "from package their-scenarios 1.2"
    assert find_scenario("hinge-hand") is SCENARIOS["hinge-hand"]


def test_a_scenario_that_is_broken_is_one_line(package):
    for name, message in (
        ("failing", "scenario 'failing': expected it to work, got ZeroDivisionError"),
        ("gone", "scenario 'gone': unknown scenario in their_things 'GONE'; known: "),
        ("their-arms", "unknown scenario 'their-arms'; known: .*did you mean 'their-arm'"),
    ):
        with pytest.raises(InputError, match=message):
            simulate(name)
    assert simulate("hinge-planar")[0].name == "hinge-planar-0"


CLAIM = """
estimator = "seel2012"
scenario = "{scenario}"
over = "median"
confidence = 0.9
power = 0.9
[claim.axis]
figure = "best_pairing_rmsae"
at_most = "3 deg"
"""


def test_a_claim_may_be_about_a_scenario_of_a_package(package, tmp_path):
    """`check` knew our own scenarios alone; what is kept of its runs goes with one version of the package."""
    (tmp_path / "claims.toml").write_text(CLAIM.format(scenario="their-arm"))
    done = here("check", tmp_path / "claims.toml", "--workers", "1", "--out", tmp_path / "out")
    assert done.code == 0, done.err
    (claim,) = load_claims(tmp_path / "claims.toml")
    before = claim.scenario.key
    assert before.startswith("name their-arm, ")
    with (tmp_path / "site" / "their_things.py").open("a") as file:
        file.write("\nMORE = 1\n")
    assert claim.scenario.key != before


def test_a_claim_about_a_scenario_that_is_broken_or_unknown_is_one_line(package, tmp_path):
    for name, message in (
        ("gone", "scenario 'gone': unknown scenario in their_things 'GONE'"),
        ("their-arms", "unknown scenario in claims.toml: claim.axis.scenario 'their-arms'; known: .*'their-arm'"),
    ):
        (tmp_path / "claims.toml").write_text(CLAIM.format(scenario=name))
        with pytest.raises(InputError, match=message):
            load_claims(tmp_path / "claims.toml")
