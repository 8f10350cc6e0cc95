"""Files of claims: what they say is taken as it stands, and every mistake is one line."""

import math
from pathlib import Path

import pytest

from imubench.checks.claim import load_claims
from imubench.checks.figures import KNOWN, figures_of
from imubench.checks.scenario import Drawn, Named
from imubench.errors import InputError
from imubench.estimators import ESTIMATORS
from imubench.run import simulate
from imubench.score import score
from tests.claimed import AXIS, loaded, written


def test_a_claim_says_what_it_is_about(tmp_path):
    often = '[claim.often]\nfigure = "maxae"\nat_most = "0.1 rad"\nat_least = 0.9\nscenario = "hinge-planar"\n'
    axis, other = loaded(tmp_path, AXIS + "margin = 0.5\n" + often)
    assert (axis.estimator, axis.over, axis.margin, axis.confidence) == ("seel2012", "rms", 0.5, 0.99)
    assert axis.bound.si == pytest.approx(math.radians(2.0))
    assert isinstance(axis.scenario, Drawn)
    assert axis.sentence == "best_pairing_rmsae of seel2012 on quick: rms <= 2 deg"
    assert other.scenario == Named("hinge-planar")
    assert other.broken_at == pytest.approx(0.9 / 1.1)  # the odds of a bad run are 1 : 9, and then 2 : 9
    assert other.asked == "<= 0.1 rad in at least 90 % of the runs"


def test_an_estimator_in_a_file_lies_beside_the_claims(tmp_path, monkeypatch):
    (tmp_path / "mine.py").write_text("def estimate(recording):\n    return None\n")
    path = written(tmp_path, AXIS + 'estimator = "mine.py:estimate"\n')
    monkeypatch.chdir("/")
    (claim,) = load_claims(path)
    assert claim.estimator == f"{tmp_path.resolve()}/mine.py:estimate"
    assert claim.named == "mine.py:estimate"
    assert load_claims(path, "olsson2020")[0].estimator == "olsson2020"


def test_a_scenario_is_known_by_what_is_in_it(tmp_path):
    (one,) = loaded(tmp_path)
    again = written(tmp_path, AXIS.replace("axis", "other")).read_text()
    (same,) = load_claims(written(tmp_path))
    assert one.scenario.key == same.scenario.key
    (tmp_path / "claims.toml").write_text(again.replace("seconds = 10", "seconds = 11"))
    assert load_claims(tmp_path / "claims.toml")[0].scenario.key != one.scenario.key


def test_every_figure_of_a_score_is_known():
    found = set()
    for scenario, name in (("hinge-hand", "olsson2020"), ("hinge-hand", "hinge-position"), ("pendulum-rigid", "mrvs")):
        recording, truth = simulate(scenario)
        found |= set(figures_of(score(ESTIMATORS[name].estimate(recording), truth)))
    assert found == set(KNOWN)


BAD = {  # what stands in the file beside the scenario, and what is said about it
    "no claim": ("", "expected one [claim.NAME] table or more"),
    "unknown key": (AXIS + "limit = 2\n", "unknown key in claims.toml: claim.axis 'limit'"),
    "no figure": ('[claim.axis]\nat_most = "2 deg"\n', "expected the key 'figure'"),
    "unknown figure": (AXIS.replace("best_pairing_rmsae", "rmse"), "unknown figure of seel2012"),
    "figure of another quantity": (AXIS.replace("best_pairing_rmsae", "error_imu1"), "known: rmsae, maxae"),
    "no unit": (AXIS.replace("2 deg", "2"), "expected a number above 0 and its unit, as in '2 deg', got '2'"),
    "a wrong unit": (AXIS.replace("2 deg", "2 mm"), "unknown unit of best_pairing_rmsae"),
    "a negative bound": (AXIS.replace("2 deg", "-2 deg"), "expected a number above 0 and its unit"),
    "unknown estimator": (AXIS + 'estimator = "seel2013"\n', "unknown estimator 'seel2013'"),
    "unknown scenario": (AXIS + 'scenario = "slow"\n', "unknown scenario in claims.toml: claim.axis.scenario 'slow'"),
    "two kinds of bound": (AXIS + 'at_least = 0.9\nover = "mean"\n', "expected 'over' or 'at_least', got both"),
    "all runs": (AXIS + "at_least = 1.0\n", "expected less than 1, which no number of runs can show"),
    "no room": (AXIS + "at_least = 0.9\nbroken_at = 0.95\n", "broken_at: expected less than at_least = 0.9, got 0.95"),
    "a lone share": (AXIS + "broken_at = 0.5\n", "broken_at: expected it with 'at_least'"),
    "over what": (AXIS + 'over = "max"\n', "unknown over in claims.toml: claim.axis 'max'; known: rms, mean, median"),
    "confidence": (AXIS + "confidence = 1.0\n", "confidence: expected less than 1"),
    "max_runs": (AXIS + "max_runs = 0\n", "max_runs: expected a whole number from 1 to a million"),
    "own name": ("[scenarios.hinge-hand]\n" + AXIS, "expected a name of its own"),
    "rigs shared": (
        "[scenarios.x]\nrecordings_per_rig = 5\n" + AXIS + 'scenario = "x"\n',
        "recordings_per_rig: expected 1",
    ),
    "a bad spec": ('[scenarios.x]\nseconds = "long"\n' + AXIS + 'scenario = "x"\n', "scenarios.x: seconds: expected"),
    "a file elsewhere": (
        '[[scenarios.x.imu]]\nprofile = "a"\nfile = "../a.toml"\n[[scenarios.x.rig]]\nfamily = "hinge"\n'
        + AXIS + 'scenario = "x"\n',
        "expected a file beside the claims or below it, got '../a.toml'",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_a_mistake_is_one_line(name, tmp_path):
    text, told = BAD[name]
    with pytest.raises(InputError) as error:
        load_claims(written(tmp_path, text))
    assert told in str(error.value)
    assert "\n" not in str(error.value)


def test_the_example_of_the_docs_is_read():
    folder = Path(__file__).resolve().parent.parent / "docs" / "examples" / "claims"
    axis, worst = load_claims(folder / "claims.toml")
    assert axis.figure == "best_pairing_rmsae"
    assert worst.over == "share"


def test_the_docs_show_the_example_as_it_is():
    docs = Path(__file__).resolve().parent.parent / "docs"
    page = (docs / "your-claim.md").read_text()
    assert (docs / "examples" / "claims" / "claims.toml").read_text() in page
    step = page.partition("```yaml\n")[2].partition("```")[0]
    assert step
    assert step in (docs / "examples" / "claims" / "claims.yml").read_text()
