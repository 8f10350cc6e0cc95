"""What a diagnosis of a recording that makes no sense says and writes."""

from dataclasses import replace

import pytest

from imubench.diagnosis import on_disk
from imubench.diagnosis.budget import Budget
from imubench.diagnosis.nonsense.swapped import reading
from imubench.diagnosis.pipeline import diagnose
from imubench.diagnosis.report.headline import headline
from imubench.diagnosis.result_file import as_dict
from imubench.diagnosis.result_read import read_diagnosis
from imubench.format1 import write_recording
from imubench.reproduce.report import escape
from tests.diagnosis.nonsense.recordings import changed, flip, held, of_two, with_imu


@pytest.mark.parametrize("case", ["unrelated", pytest.param("mirrored", marks=pytest.mark.long), "swapped", "stuck"])
def test_a_diagnosis_of_nonsense_ends_before_any_fit_and_says_it(made, case):
    recording = made("hinge", 1)
    one, two = recording.imus
    odd = {
        "unrelated": of_two(recording, made("hinge", 2)),
        "mirrored": changed(recording, "imu2", flip(2), flip(2)),
        "swapped": replace(recording, imus=(reading(one, two), reading(two, one))),
        "stuck": with_imu(recording, "imu2", gyro=held(two.gyro, [0, 1, 2])),
    }[case]
    budget = Budget(0.0)  # with no time for any fit
    found, evidence = diagnose(odd, budget=budget)
    assert not budget.not_tried
    assert found.verdict == "unexplained"
    assert [f.effect for f in found.findings] == ["unknown"]  # and no saturation
    (wrong,) = found.nonsense
    assert found.findings[0].at == wrong.at
    assert wrong.what[3:] in headline(found)  # but for a capital letter
    assert not found.fitted
    assert evidence.traces


@pytest.mark.parametrize("case", ["two samples", "stuck"])
def test_every_file_of_a_diagnosis_of_nonsense_is_written(made, case, tmp_path):
    recording = made("hinge", 1)
    one, two = recording.imus
    ends = [0, -1]
    if case == "stuck":
        odd = with_imu(recording, "imu2", gyro=held(two.gyro, [0, 1, 2]))
    else:
        odd = replace(
            recording, imus=(replace(one, time=one.time[ends], gyro=one.gyro[ends], accel=one.accel[ends]), two)
        )
    write_recording(odd, tmp_path / "rec")
    done = on_disk.diagnose_on_disk(tmp_path / "rec", tmp_path / "out")
    assert {"diagnosis.json", "diagnosis.rrd", "model", "report.html"} <= {p.name for p in (tmp_path / "out").iterdir()}
    again = read_diagnosis(tmp_path / "out")
    assert as_dict(again) == as_dict(done.diagnosis)
    (wrong,) = again.nonsense
    assert escape(wrong.what) in (tmp_path / "out" / "report.html").read_text()
    assert again.verdict == ("unexplained" if case == "stuck" else "unobservable")
    assert wrong.missing == (case != "stuck")
