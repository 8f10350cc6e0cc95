"""Scenarios for tests that take each of them: the paper's motions and sequences are alike, so one of each is quick."""

import pytest

from imubench.scenarios import SCENARIOS

ONE_OF_EACH = ("olsson2020/motion-11", "olsson2020/sequence-3")
QUICK = [name for name in SCENARIOS if not name.startswith("olsson2020/") or name in ONE_OF_EACH]
EVERY = [pytest.param(name, marks=() if name in QUICK else pytest.mark.long) for name in SCENARIOS]
