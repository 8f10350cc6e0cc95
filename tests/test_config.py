"""Every threshold of the diagnosis says what it is, cannot be changed by chance, and stands in the reference."""

from dataclasses import FrozenInstanceError, fields
from pathlib import Path

import pytest

from imubench.setting import SOURCES, setting, settings_of
from imubench.threshold_table import modules, page, records, shown

DOCS = Path(__file__).resolve().parent.parent / "docs"
RECORDS = {name: record for module in modules() for name, record in records(module)}


def test_the_reference_says_what_the_code_has():
    assert (DOCS / "thresholds.md").read_text(encoding="utf-8") == page(), "run python scripts/threshold_table.py"


def test_names_of_records_are_unique():
    assert len(RECORDS) == sum(1 for module in modules() for _ in records(module))


@pytest.mark.parametrize("name", RECORDS)
def test_a_record_has_at_most_15_fields_each_with_a_unit_a_reason_and_a_source(name):
    told = list(settings_of(RECORDS[name]))
    assert [s.name for s in told] == [f.name for f in fields(RECORDS[name])]
    assert 1 <= len(told) <= 15
    for s in told:
        assert s.unit and len(s.reason) > 3 and s.source in SOURCES, s.name


@pytest.mark.parametrize("name", RECORDS)
def test_a_record_cannot_be_changed(name):
    first = fields(RECORDS[name])[0].name
    with pytest.raises(FrozenInstanceError):
        setattr(RECORDS[name], first, 0)


def test_an_unknown_source_is_refused():
    with pytest.raises(ValueError, match="unknown source 'hearsay'; known: statistics, physics"):
        setting(1.0, "s", "why", "hearsay")


def test_values_are_shown_short():
    assert shown((1.0, 2.5, 1e-9)) == "1, 2.5, 1e-09"
    assert shown(8_000_000) == "8000000"
