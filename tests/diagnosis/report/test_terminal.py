"""What the terminal says of a diagnosis is what its page says."""

from imubench.diagnosis.report import Paths, page
from imubench.diagnosis.result import Finding, Interval, Nonsense
from tests.diagnosis.report.diagnoses import said, simulated
from tests.diagnosis.test_diagnosis_result import diagnosis, evidence


def test_the_terminal_says_the_same_and_what_to_type(capsys):
    d, shown = simulated()
    text = said(d, shown, capsys, Paths("rec", "out"))
    for words in (
        "explained: The simulation leaves out a soft mount that imu2 moves on as on springs.",
        "alarm: a soft mount that imu2 moves on as on springs may matter: joint axis 7.60 and 3.60 deg",
        "imu2 accelerometer x: 0.85 as declared, 0.014 with what was found (m/s²; noise 0.030)",
        "immaterial, below 0.5 deg and 5 mm:\n  gyro_bias at imu1 (90 % sure) moves orientation",
        "hinge angle 0.90 deg RMS. Without it 96 % of the difference comes back.",
        "imubench estimate olsson2020 rec --with out\n",
    ):
        assert words in text, words
    small = diagnosis(findings=d.findings[1:])
    text = said(small, shown, capsys)
    assert "no alarm: nothing that is sure moves a joint or a segment by 0.5 deg and 5 mm." in text
    assert "a constant offset of imu1's gyroscope, which moves nothing by 0.5 deg and 5 mm." in text


def test_a_recording_that_makes_no_sense_is_told_so_and_what_to_look_at(capsys):
    wrong = Nonsense("imu2", "imu2 looks mirrored in z", {}, ("gyr_z",), "check the signs and the order of imu2's axes")
    unknown = Finding("unknown", "imu2", 0.9, {}, Interval(0.0, (0.0, 0.0)))
    d = diagnosis(verdict="unexplained", findings=(unknown,), where=(), nonsense=(wrong,))
    html = page(d, evidence())
    assert "imu2 looks mirrored in z. No simulation can be held against that." in html
    assert "<dt>What next?</dt><dd><p>To do: check the signs and the order of imu2&#x27;s axes.</p></dd>" in html
    assert "Because of what" not in html and "<svg" not in html and "model</code>" not in html
    text = said(d, evidence(), capsys)
    assert text.count("check the signs and the order of imu2's axes") == 1
