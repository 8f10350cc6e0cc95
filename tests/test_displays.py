"""What a recording, a truth, an estimate, a score and a diagnosis show of themselves."""

import re
import sys
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pandas as pd
import pytest

import imubench as ib
from imubench.diagnosis.result import Diagnosis
from imubench.diagnosis.result_simulation import SimulatedChannel, Simulation
from imubench.displays.svg import POINTS, bars, traces
from imubench.recording import Encoder, Pose
from tests.diagnosis.test_diagnosis_result import diagnosis

KINDS = ("Recording", "Truth", "Estimate", "stream", "Score", "Diagnosis", "played")


@pytest.fixture(scope="module")
def shown():
    recording, truth = ib.simulate("hinge-planar", seed=1)
    estimate = ib.estimate("olsson2020", recording)
    n = 700
    value = np.random.default_rng(0).normal(size=(n, 1, 3))
    stream = ib.Estimate(
        "joint_vector", "mine", value, np.broadcast_to(np.diag([1.0, 4.0, 9.0]), (n, 3, 3)), time=np.arange(n) / 100
    )
    plain = diagnosis()
    channels = {"imu1.gyr_x": SimulatedChannel("rad/s", 0.3, 0.004, 0.002)}
    played = replace(plain, simulation=Simulation("prescribed", ((0.0, 5.0),), True, channels))
    values = (recording, truth, estimate, stream, ib.score(estimate, truth), plain, played)
    return dict(zip(KINDS, values, strict=True))


def test_recordings_truths_and_their_parts_are_a_line(shown):
    recording, truth = shown["Recording"], shown["Truth"]
    parts = [recording, truth, *recording.imus, *truth.segments, *truth.sensors]
    parts += [Encoder("hinge", [0.0, 1.0], [0.0, 0.1]), Pose("segment1", [0.0], position=[[0.0, 0.0, 0.0]])]
    parts.append(ib.Reference(np.arange(3.0), hinge_angle=np.zeros(3)))
    for part in parts:
        text = repr(part)
        assert len(text) < 160 and "\n" not in text and type(part).__name__ in text
    assert repr(recording).startswith("<Recording 'hinge-planar-1': hinge, 0 to ")
    assert "imu1, imu2, hinge angle" in repr(truth)


def test_a_recording_as_a_table_has_every_sample_of_every_imu(shown):
    recording = shown["Recording"]
    table = recording.to_pandas()
    for imu in recording.imus:
        own = table[table["imu"] == imu.name]
        assert np.array_equal(own["time"], imu.time)
        assert np.array_equal(own[["gyr_x", "gyr_y", "gyr_z"]], imu.gyro)
        assert np.array_equal(own[["acc_x", "acc_y", "acc_z"]], imu.accel)


def test_a_truth_as_a_table_has_the_columns_of_a_dataset(shown):
    truth = shown["Truth"]
    table = truth.to_pandas()
    assert np.array_equal(table["hinge_angle"], truth.joint_angle)
    assert np.array_equal(table["segment2_quaternion_w"], truth.segments[1].quaternion[:, 0])
    assert np.array_equal(table["imu2_true_joint_axis_y"], truth.sensor("imu2").joint_axis[:, 1])


def test_an_estimate_as_a_table_has_its_standard_deviations(shown):
    estimate = shown["Estimate"]
    table = estimate.to_pandas()
    assert list(table["imu"]) == ["imu1", "imu2"]
    assert np.array_equal(table[["x", "y", "z"]], estimate.value)
    stds = np.sqrt(np.diag(estimate.covariance)).reshape(2, 3)
    assert np.array_equal(table[["std_x", "std_y", "std_z"]], stds)
    stream = shown["stream"].to_pandas()
    assert len(stream) == 700 and set(stream["std_z"]) == {3.0} and stream["time"].iloc[-1] == 6.99


def test_scores_and_diagnoses_as_tables(shown):
    score = shown["Score"]
    assert dict(zip(score.to_pandas()["figure"], score.to_pandas()["value"], strict=True)) == score.figures
    (row,) = shown["Diagnosis"].to_pandas().to_dict("records")
    assert (row["effect"], row["at"], row["parameter"], row["value"], row["unit"]) == (
        "soft_mount", "imu2", "frequency", 11.2, "Hz",
    )  # fmt: skip
    empty = replace(shown["Diagnosis"], findings=(), verdict="no mismatch").to_pandas()
    assert isinstance(empty, pd.DataFrame) and empty.empty and "effect" in empty


@pytest.mark.parametrize("kind", KINDS)
def test_each_is_drawn(shown, kind, tmp_path):
    figure = shown[kind].plot()
    assert figure.axes and any(axes.has_data() for axes in figure.axes)
    figure.savefig(tmp_path / "x.png", dpi=40)
    assert (tmp_path / "x.png").stat().st_size > 2000  # an empty one of this size has 600 bytes


class Sound(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.names: set[str] = set()

    def handle_starttag(self, tag, attrs):
        self.names.add(tag)
        assert not {"src", "href"} & {name for name, _ in attrs}
        if tag not in ("br", "rect", "polyline"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs) if tag not in ("rect", "polyline") else self.names.add(tag)


@pytest.mark.parametrize("kind", KINDS)
def test_in_a_notebook_each_is_small_sound_html_that_needs_no_package(shown, kind, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    monkeypatch.setitem(sys.modules, "pandas", None)
    text = shown[kind]._repr_html_()
    assert len(text) < 40_000
    sound = Sound()
    sound.feed(text)
    assert sound.open == []
    assert "svg" in sound.names or kind == "Estimate"  # axes are six numbers: a table
    assert not {"script", "link", "img"} & sound.names


def test_names_of_strangers_are_no_markup():
    recording, _ = ib.simulate("hinge-planar", seed=1)
    text = replace(recording, name="<script>alert(1)</script>")._repr_html_()
    assert "<script>" not in text and "&lt;script&gt;" in text


@pytest.mark.parametrize(
    ("package", "call", "extra"), [("matplotlib.figure", "plot", "plot"), ("pandas", "to_pandas", "pandas")]
)
def test_without_the_package_one_line_says_what_to_install(shown, package, call, extra, monkeypatch):
    monkeypatch.setitem(sys.modules, package, None)
    wanted = f"expected {package.partition('.')[0]}, got none; pip install 'imubench[{extra}]'"
    with pytest.raises(ib.InputError, match=re.escape(wanted)):
        getattr(shown["Score"], call)()


def test_a_long_trace_keeps_its_extremes_and_few_points():
    time = np.arange(100_000) / 100
    values = np.sin(time)[:, None]
    values[54_321] = 9.0
    drawn = traces("x", time, values)
    points = [tuple(map(float, p.split(","))) for p in drawn.split("points='")[1].split("'")[0].split()]
    assert len(points) <= 2 * POINTS
    # The peak is at the upper edge, where it is in time: 360 wide and 2 from the edge, one decimal.
    assert min(points, key=lambda p: p[1]) == pytest.approx((360 * 543.21 / time[-1], 2.0), abs=0.06)


def test_bars_of_nothing_and_of_zeros():
    assert bars("x", {}, []).startswith("<svg")
    assert "width='1.0'" in bars("x", {"a": 0.0}, ["0 deg"])


def test_a_diagnosis_is_displayed_as_the_others():
    assert {"plot", "to_pandas", "_repr_html_"} <= set(dir(Diagnosis))
