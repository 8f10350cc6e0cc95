"""The section of a finding on the page: its order, its figure, and what is said without one."""

from dataclasses import replace

from imubench.diagnosis.report import page
from imubench.diagnosis.result import Finding, Interval
from tests.diagnosis.report.diagnoses import simulated
from tests.diagnosis.test_diagnosis_result import WHERE, diagnosis, evidence


def test_findings_that_matter_come_first_by_their_share():
    d, shown = simulated()
    mount = replace(d.findings[0], share=0.1)
    pose = replace(d.findings[0], effect="mount_pose", share=0.8, parameters={})
    html = page(replace(d, findings=(d.findings[1], mount, pose)), replace(shown, comparisons=()))
    titles = (
        "</span>imu2 sitting elsewhere than the model has it ",
        "</span>A soft mount that imu2 moves on as on springs ",
        "<h2>Immaterial: below 0.5 deg and 5 mm",
    )
    places = [html.index(f"{title}<") for title in titles]
    assert places == sorted(places)


def test_a_finding_without_a_place_for_its_figure_says_what_it_moves():
    html = page(diagnosis(), replace(evidence(), comparisons=()))
    assert "It moves: joint axis 7.60 and 3.60 deg (imu1 and imu2), hinge angle 0.90 deg RMS." in html
    assert "<figcaption>" not in html  # no simulation, no comparison, nothing unknown: nothing to draw but the map


def test_something_unknown_is_drawn_and_nothing_is_not():
    unknown = Finding("unknown", "imu2", 0.8, {}, Interval(0.0, (0.0, 0.0)), where=WHERE)
    bare = replace(evidence(), comparisons=())
    html = page(diagnosis(verdict="unexplained", findings=(unknown,)), bare)
    assert "no effect of the library explains it" in html
    assert "m/s² RMS is left, where sensor noise leaves" in html
    assert "--with" not in html  # nothing can be taken out
    html = page(diagnosis(verdict="no mismatch", findings=(), where=()), bare)
    assert "Nowhere by more than the sensors&#x27; noise" in html
    assert "<figcaption>" not in html
