"""The data card says what the tables say, and needs nothing else to be looked at."""

import re
from html.parser import HTMLParser

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from imubench.dataset import parse_spec, read
from imubench.dataset.card import CARD, LIMITS, census, limits
from imubench.dataset.generate import generate
from imubench.dataset.manifest import verify
from imubench.dataset.pictures import histogram, shares
from imubench.dataset.shard import Job
from imubench.errors import InputError

SPEC = """
name = "<tried> & true"
licence = "CC0-1.0"
seconds = [2, 4]
recordings_per_rig = 3
recordings_per_file = 4
[[rig]]
family = "hinge"
[[rig]]
family = "free"
[[effect]]
name = "gyro_bias"
probability = 0.4
[[effect]]
name = "dropouts"
probability = 0.4
fraction = 0.05
"""
COUNT = 18


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("card") / "d"
    generate(Job({"spec.toml": SPEC.encode()}, 1, COUNT, str(out)), workers=0)
    return out


def test_the_census_counts_what_the_recordings_are(folder):
    files = sorted((folder / "recordings").iterdir())
    order = [number for file in files for number in pq.read_table(file)["recording"].to_pylist()]
    assert sorted(order) == list(range(COUNT))
    found, stored = census(files), [read(folder, i) for i in order]
    assert found.names["family"] == {f: sum(s.recording.rig == f for s in stored) for f in found.names["family"]}
    for name in ("gyro_bias", "dropouts"):
        assert found.effects[name] == sum(any(e["effect"] == name for e in s.effects) for s in stored)
    biases = [x for s in stored for e in s.effects if e["effect"] == "gyro_bias" for x in e["parameters"]["bias"]]
    assert list(found.parameters["gyro_bias", "bias"]) == biases
    assert list(found.numbers["seconds"]) == [s.row["seconds"] for s in stored]
    rms = [np.sqrt(np.mean(np.sum(i.gyro**2, axis=1))) for s in stored for i in s.recording.imus]
    # The samples on the disk are rounded to 24 bits, the column of rms values is not.
    assert np.allclose(found.numbers["imuN_gyro_rms"], rms, rtol=1e-6)


@pytest.mark.parametrize(
    ("column", "value", "said"),
    [
        ("effects", [{"effect": "gyr\x7f_bias", "at": "imu1", "parameters": "{}"}], r"unknown effect 'gyr"),
        ("effects", [{"effect": "gyro_bias", "at": "imu1", "parameters": '{"bias": ["a"]}'}], "row 0: expected a rec"),
        ("family", "sledge", "row 0: expected a recording as"),
    ],
)
def test_a_table_that_says_what_no_recording_has_is_one_line(folder, tmp_path, column, value, said):
    table = pq.read_table(min((folder / "recordings").iterdir()))
    rows = table.to_pylist()
    rows[0][column] = value
    pq.write_table(pa.Table.from_pylist(rows, schema=table.schema), tmp_path / "t.parquet")
    with pytest.raises(InputError, match=said):
        census([tmp_path / "t.parquet"])


def test_the_card_stands_alone_and_is_sound_html(folder):
    text = (folder / CARD).read_text()
    assert not re.findall(r"(?:src|href)=|@import|url\(", text)
    assert "&lt;tried&gt; &amp; true" in text and "<tried>" not in text
    assert "CC0-1.0" in text and f"--count {COUNT} --seed 1" in text
    for limit in LIMITS:
        assert limit in text
    balance = Balance()
    balance.feed(text)
    assert balance.open == []


class Balance(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []

    def handle_starttag(self, tag, attrs):
        if tag not in ("meta", "rect", "line"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_startendtag(self, tag, attrs):
        pass


def test_a_changed_card_is_found(folder, tmp_path):
    text = (folder / CARD).read_bytes()
    (folder / CARD).write_bytes(text.replace(b"CC0", b"CC1"))
    try:
        with pytest.raises(InputError, match=r"card.html \(changed\)"):
            verify(str(folder))
    finally:
        (folder / CARD).write_bytes(text)


def test_limits_follow_the_spec():
    plain = limits(parse_spec({"spec.toml": b"truth = 'none'\n[[rig]]\nfamily = 'free'"}))
    assert "Of the truth, nothing is stored." in plain
    assert any("every recording obeys its model" in limit for limit in plain)


def test_pictures_of_nothing_of_one_value_and_of_many():
    assert histogram(np.array([]), "a", "m") == "" and shares({}, "a", 3) == ""
    assert "always 2 m" in histogram(np.array([2.0, 2.0]), "a", "m")
    drawn = histogram(np.arange(300.0), "a", "m")
    assert drawn.count("<rect") == 30 and "median 150, nine in ten from 15 to 284 m" in drawn
    assert shares({"x": 1, "y": 3}, "a", 4).index(">y<") < shares({"x": 1, "y": 3}, "a", 4).index(">x<")
