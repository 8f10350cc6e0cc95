"""The suite of real recordings: what it asks, how answers are scored and told, and what is kept between runs."""

import json
import signal
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, replace
from itertools import pairwise

import numpy as np
import pytest

from benchmarks.real import steps
from benchmarks.real.__main__ import DOCS, HEADING, KNOWN, line, shown
from benchmarks.real.cases import Case, cases, chosen
from benchmarks.real.facts import fact_of, facts
from benchmarks.real.repeat import moved, repeated
from benchmarks.real.required import rows
from benchmarks.real.said import Said, read_said
from benchmarks.real.scoring import AxisError, CaseScore, scored
from benchmarks.real.sources import Source, knee
from benchmarks.real.steps import _done, answered, kept
from benchmarks.real.table import Halves, Line, cases_table, facts_table, halves_table, replaced
from imubench.diagnosis.result import Change, Diagnosis, Finding, FitQuality, Interval, Parameter, Rejected, Where
from imubench.diagnosis.result_file import as_dict
from imubench.errors import InputError
from imubench.rotations import from_axis_angle, rotate
from imubench.trials.blind import Children

GAIN = Interval(1.0, (0.0, 2.0))
FOAM = fact_of("diodem/trial1/3-4-foam/whole")
RIGID = fact_of("diodem/trial1/3-4-rigid/0-20")
AXES = np.array([[0.0, 1.0, 0.0], [0.0, 1.0, 0.0]])


def finding(effect, at, confidence=0.95, equivalent=(), band=None, **parameters):
    where = None if band is None else Where(at, {"acc_x": 1.0}, (band,), (), "", 1.0)
    same = tuple(Rejected(e, a, 0.0) for e, a in equivalent)
    return Finding(effect, at, confidence, parameters, GAIN, same, "", where)


def said(*findings, heldout=(5.0, 1.05), angle=None, material=None):
    sure = [f for f in findings if f.confidence >= 0.5]
    named = [f for f in sure if f.named]
    verdict = ("explained" if len(named) == len(sure) else "partly explained") if named else "unexplained"
    name = "hinge_angle_but_constant"
    change = Change() if angle is None else Change(*({name: float(np.radians(a))} for a in angle), "rad RMS")
    quality = FitQuality(heldout, reference=change)
    d = Diagnosis("r", "hinge", verdict if sure else "no mismatch", (5.0, 1.0), (), findings, (), quality, "", 1.0)
    return Said(d, tuple(material or [True] * len(findings)))


def rocking(at, **more):
    return finding("rocking_mount", at, **more)


def estimates(degrees, name="seel2012"):
    turned = rotate(from_axis_angle([1.0, 0.0, 0.0], np.radians(degrees)), AXES)
    return {name: {"status": "converged", "pairing": "from data", "value": turned.tolist()}}


def source(name, seconds=66.0):
    return Source(name, seconds, lambda: pytest.fail("nothing is read to list cases"))


COLLECTION = [
    *(source(f"diodem/trial7/{joint}-{mount}") for joint in ("2-3", "3-4", "4-5") for mount in ("foam", "rigid")),
    *(source(f"broad/{trial}", 186.0) for trial in ("02_undisturbed_slow_B", "10_undisturbed_A", "24_disturbed_tap_A")),
    source("multiarm/vad-1", 9.0),
    source("imucal/ferraris", 101.0),
    source("dot-knee/walk", 54.0),
]


def test_every_case_has_a_name_of_its_own_and_something_known():
    every = cases(COLLECTION)
    assert len({c.name for c in every}) == len(every)
    assert all(fact_of(c.name).known for c in every)
    with pytest.raises(InputError, match="expected a fact for case elsewhere/whole, got none"):
        fact_of("elsewhere/whole")


def test_parts_make_up_the_whole_and_windows_stand_at_fixed_steps():
    spans = {c.part: (c.start, c.end) for c in cases([COLLECTION[1]])}
    assert spans["whole"] == (0.0, 66.0)
    for count, name in ((2, "half"), (3, "third")):
        edges = [spans[f"{name}{i + 1}"] for i in range(count)]
        assert edges[0][0] == 0.0 and edges[-1][1] == 66.0
        assert all(a[1] == b[0] for a, b in pairwise(edges))
    assert [p for p in spans if "-" in p] == ["0-20", "10-30", "20-40", "30-50", "40-60"]
    assert not [c for c in cases([COLLECTION[0]]) if "-" in c.part]  # foam: no windows


def test_undisturbed_trials_are_baselines_of_all_others_and_come_first():
    every = cases(COLLECTION)
    given = [(c.source.name, c.baseline) for c in every if c.baseline]
    assert len(given) == 4  # two undisturbed trials of one another, and each for the disturbed one
    assert all("_undisturbed_" in baseline for _, baseline in given)
    names = [c.name for c in every]
    assert all(names.index(c.baseline) < names.index(c.name) for c in every if c.baseline)


def test_a_pattern_takes_the_baselines_that_its_cases_need():
    some = chosen(cases(COLLECTION), ["broad/24_*-after-02"])
    assert [c.name for c in some] == [
        "broad/02_undisturbed_slow_B/80-120", "broad/24_disturbed_tap_A/80-120-after-02",
    ]  # fmt: skip


def test_facts_name_effects_and_places_that_there_are(tmp_path):
    entry = 'cases = "a"\nknown = "b"\nsource = "c"\ncomplete = true\nthere = []\nmay = ["{}"]\n'
    for wrong, message in (("foam at imu1", "unknown .*effect 'foam'"), ("gyro_bias", "expected 'effect at place'")):
        file = tmp_path / f"{len(wrong)}.toml"
        file.write_text("[[fact]]\n" + entry.format(wrong))
        with pytest.raises(InputError, match=message):
            facts(file)


def test_foam_is_named_at_both_imus_or_not_named():
    both = scored(said(rocking("imu1"), finding("soft_mount", "imu2")), FOAM)
    assert both.named and both.located and both.silent is None and not both.wrong
    one = scored(said(rocking("imu1")), FOAM)
    assert not one.named and not one.located
    assert one.wrong == ("foam at imu2 not named",)


def test_an_equivalent_names_too_and_one_finding_names_one_place():
    twin = finding("low_pass", "imu1", equivalent=[("rocking_mount", "imu1"), ("rocking_mount", "imu2")])
    assert scored(said(twin, rocking("imu2")), FOAM).named
    assert not scored(said(twin), FOAM).named


@pytest.mark.parametrize(
    ("band", "at", "located"), [((9.0, 16.0), "imu2", True), ((0.5, 16.0), "imu2", False), ((9.0, 16.0), "imu1", False)]
)
def test_an_unknown_locates_by_place_and_band(band, at, located):
    score = scored(said(rocking("imu1"), finding("unknown", at, band=band)), FOAM)
    assert (score.verdict, score.named, score.located) == ("partly explained", False, located)
    assert (score.besides == ()) == located  # else it is one more thing said


def test_a_doubted_finding_counts_for_nothing():
    score = scored(said(rocking("imu1", confidence=0.4), rocking("imu2", confidence=0.4)), FOAM)
    assert (score.named, score.located, score.besides) == (False, False, ())


def test_silence_is_broken_by_what_matters_alone():
    bias = finding("accel_bias", "imu1")
    assert scored(said(), RIGID).silent
    assert scored(said(bias), RIGID).besides == ("accel_bias at imu1 (0.95)",)
    assert scored(said(bias, material=[False]), RIGID).silent
    assert not scored(said(finding("unknown", "imu1")), RIGID).silent


def test_explained_is_wrong_by_each_contradiction():
    foam = rocking("imu1"), rocking("imu2")
    assert scored(said(*foam, heldout=(9.0, 4.4)), FOAM).wrong == ("held out 4.40",)
    assert scored(said(*foam, angle=(2.7, 9.6)), FOAM).wrong == ("hinge angle 2.70 to 9.60 deg",)
    assert scored(said(*foam, angle=(1.23, 0.6)), FOAM).wrong == ()
    extra = scored(said(*foam, finding("vibration", "imu1")), FOAM)
    assert extra.wrong == ("vibration at imu1 is not there",)
    assert scored(said(*foam, finding("vibration", "imu1", 0.8)), FOAM).wrong == ()
    assert scored(said(*foam, finding("gyro_bias", "imu1")), FOAM).wrong == ()  # it may be there
    assert scored(said(*foam, finding("vibration", "imu1")), replace(FOAM, complete=False)).wrong == ()


def test_other_verdicts_are_not_wrong_but_explained():
    partly = said(rocking("imu1"), finding("unknown", "imu2", band=(9.0, 16.0)), heldout=(9.0, 4.4), angle=(2.7, 9.6))
    score = scored(partly, FOAM)
    assert score.wrong == () and score.angle_worse


def test_axes_that_get_worse_are_wrong():
    d = said(rocking("imu1"), rocking("imu2"))
    worse = scored(d, FOAM, estimates(1.0), estimates(3.0), AXES)
    assert worse.wrong == ("axis by seel2012 1.0 / 1.0 to 3.0 / 3.0 deg",)
    assert np.degrees(worse.axes["seel2012"][1].off) == pytest.approx([3.0, 3.0])
    assert scored(d, FOAM, estimates(3.0), estimates(1.0), AXES).wrong == ()


def test_a_diagnosis_that_is_refused_leaves_the_axes_as_they_were():
    score = scored(said(rocking("imu1"), rocking("imu2")), FOAM, estimates(1.0), {"refused": "no trust"}, AXES)
    assert score.axes["seel2012"][1] == AxisError(None, "no trust")
    assert score.wrong == ()
    failed = scored(said(), FOAM, {"seel2012": {"status": "refused: too short"}}, {}, AXES)
    assert failed.axes["seel2012"][0] == AxisError(None, "refused: too short")


def test_a_diagnosis_on_disk_may_say_what_is_material(tmp_path):
    content = as_dict(said(rocking("imu1"), finding("gyro_bias", "imu1")).diagnosis)
    content["findings"][1]["material"] = False
    (tmp_path / "diagnosis.json").write_text(json.dumps(content))
    assert read_said(tmp_path).material == (True, False)


def spring(hz, std=0.1, at="imu1", **more):
    return rocking(at, frequency=Parameter(np.array(hz), np.full(3, std), "Hz"), **more)


def whys(one, other):
    return [f.why for f in repeated(said(*one), said(*other), 40.0)]


def test_halves_agree_by_name_and_numbers():
    here, near, far = spring([10.0, 12.0, 15.0]), spring([10.2, 12.1, 15.0]), spring([11.0, 12.0, 15.0])
    assert whys([here], [near]) == ["", ""]
    assert whys([here], [far]) == ["frequency 7 std apart"] * 2  # 1 Hz over 0.14
    assert whys([here], []) == ["not there"]
    assert whys([here], [finding("soft_mount", "imu1", 0.6)]) == ["not there"]
    twin = finding("soft_mount", "imu1", 0.6, equivalent=[("rocking_mount", "imu1")])
    assert whys([spring([10.0, 12.0, 15.0], equivalent=[("soft_mount", "imu1")])], [twin]) == [""]
    assert whys([finding("impacts", "imu1")], []) == []  # knocks of one half say nothing of the other
    assert whys([finding("gyro_bias", "imu1", 0.8)], []) == []


def test_axes_between_halves_know_no_sign():
    one, other = estimates(0.0), estimates(2.0)
    other["seel2012"]["value"] = (-np.array(other["seel2012"]["value"])).tolist()
    assert np.degrees(moved(one, other)["seel2012"]) == pytest.approx([2.0, 2.0])
    assert moved(one, {"refused": "why"}) == {}


def test_a_section_is_replaced_and_its_neighbours_stay():
    text = "# T\n\n## A\n\nold\n\n### of A\n\nold\n\n## B\n\nstays\n"
    assert replaced(text, "## A", "new\n") == "# T\n\n## A\n\nnew\n\n## B\n\nstays\n"
    assert replaced(text, "## B", "new") == text.replace("stays", "new")
    assert replaced("# T\n", "## C", "new") == "# T\n\n## C\n\nnew\n"
    assert replaced(replaced(text, "## A", "x"), "## A", "new\n") == replaced(text, "## A", "new\n")


def test_the_documentation_has_what_is_known_as_the_suite_has_it():
    text = DOCS.read_text(encoding="utf-8")
    assert replaced(text, KNOWN, facts_table(facts())) == text  # python -m benchmarks.real --table --write
    assert all(heading in file.read_text(encoding="utf-8") for file, heading in HEADING.items())


LINES = [
    Line("diodem/trial1/3-4-foam/whole", "foam", "", scored(said(rocking("imu1")), FOAM), 130.0, 1.5),
    Line("diodem/trial1/3-4-foam/half1", "foam", "no diagnosis: ended with -24", None, 720.0, 2.0),
]


def test_the_tables_show_failures_as_well():
    table = cases_table(LINES).splitlines()
    assert len({row.count(" | ") for row in table}) == 1
    assert "foam at imu2 not named" in table[2] and "no diagnosis: ended with -24" in table[3]
    halves = halves_table([Halves("r", repeated(said(spring([9.0, 9.0, 9.0])), said(), 40.0))])
    assert "| 0 of 1 | rocking_mount at imu1: not there |" in halves


def test_a_case_without_a_diagnosis_is_no_success():
    found = {r.what: r for r in rows(LINES, [])}
    foam = found["foam named or located at both IMUs"]
    assert (foam.ours, foam.met) == ("0 of 2", False)
    assert (found["wrong but explained"].ours, found["wrong but explained"].met) == ("1 of 1", False)
    assert found["hinge angle of diodem/trial1/3-4-foam/whole"].ours == "none"
    assert not found["largest memory of a whole trial, the most of 1"].met
    assert not [what for what in found if "taps" in what]  # no such recording is among the cases


@pytest.mark.parametrize(("degrees", "met"), [(0.2, True), (0.5, False)])
def test_axes_on_foam_are_held_to_what_a_filter_reaches(degrees, met):
    off = AxisError(np.radians([degrees, 1.0]), "converged")
    score = CaseScore("explained", axes={"olsson2020-banded": (off, off)})
    lines = [Line(f"diodem/trial1/3-4-foam/{part}", "foam", "", score) for part in ("whole", "third1")]
    what = "axes of joint 3-4 on foam by olsson2020-banded, raw and converged, whole and thirds"
    row = next(r for r in rows(lines, []) if r.what == what)
    assert row.met == met
    late = CaseScore("explained", axes={"olsson2020-banded": (replace(off, status="not converged"), off)})
    assert not next(r for r in rows([replace(lines[0], score=late)], []) if r.what == what).met


def test_a_process_is_measured_bounded_and_not_run_again(tmp_path):
    grown = tmp_path / "grown"
    words = ["-c", f"open({str(grown)!r}, 'a').write('x'); x = bytearray(10**8); print(sum(range(10**6)))"]
    step = _done("first", words, tmp_path, 20.0, 0.0, Children())
    assert step.code == 0 and not step.failed
    assert step.memory > 0.1 and step.seconds > 0.0  # GB: it has a tenth of its own
    assert _done("first", words, tmp_path, 20.0, 0.0, Children()) == step
    assert grown.read_text() == "x"
    endless = _done("endless", ["-c", "while True: pass"], tmp_path, 1.0, 0.0, Children())
    assert -endless.code in (signal.SIGXCPU, signal.SIGKILL)
    assert endless.failed == f"ended with {endless.code}"
    broken = _done("broken", ["-c", "raise SystemExit('no such sensor')"], tmp_path, 5.0, 0.0, Children())
    assert broken.failed == "no such sensor"


def test_what_an_interrupted_run_was_doing_is_done_again(tmp_path):
    children = Children()
    with ThreadPoolExecutor(1) as pool:
        words = ["-c", "import time; print('begun', flush=True); time.sleep(60)"]
        running = pool.submit(_done, "cut", words, tmp_path, 20.0, 0.0, children)
        while not (tmp_path / "cut.txt").is_file() or not (tmp_path / "cut.txt").read_text():
            time.sleep(0.01)
        children.stop()
        assert running.result().code == -signal.SIGKILL
    _done("next", words, tmp_path, 20.0, 0.0, children)
    assert [p.name for p in tmp_path.iterdir()] == ["cut.txt"]  # not begun, and nothing finished
    nothing = kept(Case(COLLECTION[0], "whole", 0.0, 66.0), tmp_path)
    assert (nothing.diagnosed, nothing.why_not, nothing.estimates("raw")) == (False, "not run yet", {})


def test_a_case_that_cannot_be_asked_says_why_and_stops_nothing(tmp_path, monkeypatch):
    def broken():
        raise InputError("imu1.csv: expected numbers, got none")

    case = Case(Source("diodem/trial7/3-4-foam", 66.0, broken), "whole", 0.0, 66.0)
    answer = answered(case, tmp_path, 5.0, Children())
    assert answer.why_not == "not converted: imu1.csv: expected numbers, got none" and not answer.diagnosed
    assert line(answer).failed == answer.why_not and line(answer).score is None
    given = replace(case, baseline="broad/02_undisturbed/80-120")
    for known, why in ((False, "imubench diagnose takes no --baseline"), (True, f"no diagnosis of {given.baseline}")):
        monkeypatch.setattr(steps, "knows_baselines", lambda known=known: known)
        assert answered(given, tmp_path, 5.0, Children()).why_not == why


def test_an_answer_that_cannot_be_read_is_a_line_of_the_table(tmp_path):
    case = Case(COLLECTION[1], "0-20", 0.0, 20.0)
    folder = tmp_path / case.name
    (folder / "diagnosis").mkdir(parents=True)
    (folder / "known.json").write_text(json.dumps({"hinge": True, "axes": AXES.tolist(), "seconds": 20.0}))
    (folder / "diagnosis" / "diagnosis.json").write_text(json.dumps(as_dict(said().diagnosis)))
    for name, code in (("diagnose", 0), ("axes-with", -24)):
        step = steps.Step(code, 9.0, 0.5, 600.0, "abc")
        (folder / f"{name}.step.json").write_text(json.dumps(asdict(step)))
    (folder / "axes-raw.json").write_text(json.dumps(estimates(1.0)))
    one = line(kept(case, tmp_path))
    assert (one.score.verdict, one.score.silent, one.seconds) == ("no mismatch", None, 9.0)  # 2-3: play is known
    before, after = one.score.axes["seel2012"]
    assert np.degrees(before.off) == pytest.approx([1.0, 1.0]) and after == AxisError(None, "ended with -24")
    (folder / "diagnosis" / "diagnosis.json").write_text("{}")
    broken = line(kept(case, tmp_path))
    assert broken.failed == "diagnosis cannot be read: /diagnosis/diagnosis.json: key 'format': expected, got none"


def test_messages_in_the_tables_name_no_folder_of_this_machine(tmp_path, monkeypatch):
    monkeypatch.setenv("IMUBENCH_DATA", "/lab/recordings")
    text = shown(
        f"{tmp_path}/case/recording: beside /lab/recordings/broad, in {steps.ROOT}/benchmarks", tmp_path / "case"
    )
    assert text == "/recording: beside IMUBENCH_DATA/broad, in /benchmarks"


EXPORT = """sep=,
DeviceTag:,Femur
StartTime: ,2024-12-09_17:31:07_886 CET
© Movella Technologies B. V. 2005-2024

PacketCounter,SampleTimeFine,Acc_X,Acc_Y,Acc_Z,Gyr_X,Gyr_Y,Gyr_Z,Mag_X,Mag_Y,Mag_Z
"""


def test_an_export_of_the_movella_app_is_read_on_one_clock(tmp_path):
    for name, first in (("femur", 1_000_000), ("tibia", 1_016_667)):
        lines = [f"{i},{first + 16667 * i},0,0,9.81,180,0,0,1,0,0\n" for i in range(5)]
        (tmp_path / f"{name}.csv").write_text(EXPORT + "".join(lines), encoding="utf-8")
    one, other = knee(tmp_path).imus
    assert (one.time[0], one.rate) == (0.0, 60.0)
    assert other.time[0] == pytest.approx(0.016667, abs=1e-9)  # s: stamps of 1 us in 64 bits
    assert one.gyro[0] == pytest.approx([np.pi, 0, 0]) and one.accel[0].tolist() == [0, 0, 9.81]
    (tmp_path / "tibia.csv").write_text("a,b\n" * 40)
    with pytest.raises(InputError, match="expected a line that begins with PacketCounter"):
        knee(tmp_path)
