"""What is shown while something runs: on a terminal one line that changes, elsewhere a line for each stage."""

import io

import pytest

from imubench.progress import READING, Stage, in_stages, silent, tell
from imubench.terminal import Terminal

PLAN = ("read ", "fit", "search", "draw")


def shown(step_of, *names, fail=None):
    """What a step writes to a stream that is no terminal, for these stages one after the other."""
    console = Terminal()
    console.file = io.StringIO()
    step = step_of(console)
    for name in names:
        with step(name):
            tell(f"trying within {name}")
            if name == fail:
                raise ValueError(name)
    return console.file.getvalue().splitlines()


def test_without_a_terminal_each_stage_is_a_plain_line():
    lines = shown(lambda c: in_stages(c, PLAN), "read rec", "fit", "search", "draw")
    assert [line.partition(", ")[0] for line in lines] == ["2 of 4", "3 of 4", "4 of 4"]
    assert lines[0].endswith(" s: fit")
    assert not any("\x1b" in line for line in lines)


def test_a_stage_that_is_left_out_is_counted_and_one_more_is_the_next():
    lines = shown(lambda c: in_stages(c, PLAN), "read rec", "search", "another", "draw", "more")
    assert [line.partition(", ")[0] for line in lines] == ["3 of 4", "4 of 4", "5 of 5", "6 of 6"]


def test_a_stage_that_begins_again_has_its_number_and_so_have_those_after_it():
    lines = shown(lambda c: in_stages(c, PLAN), "read rec", "fit", "search", "fit anew", "search", "draw")
    assert [line.partition(", ")[0] for line in lines] == ["2 of 4", "3 of 4", "2 of 4", "3 of 4", "4 of 4"]


def test_reading_says_nothing_so_that_broken_input_is_one_line():
    assert PLAN[0] == READING
    with pytest.raises(ValueError, match="read rec"):
        shown(lambda c: in_stages(c, PLAN), "read rec", fail="read rec")


def test_what_is_tried_stands_beside_the_stage():
    stage = Stage("search", 3, 4, 0.0)
    stage.detail = "scoring\x1b[31m every effect"
    assert str(stage).startswith("3 of 4, ")
    assert str(stage).endswith("s: search: scoring\\x1b[31m every effect")  # control characters are shown
    assert str(stage.__rich__()) == str(stage)


def test_a_stage_that_ends_is_told_nothing_more():
    with in_stages(Terminal(stderr=True), PLAN)("fit"):
        pass
    tell("nobody listens")
    with silent("anything"):
        tell("nobody listens")
