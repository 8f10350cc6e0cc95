"""The tests, a package so that they may share what they are made of."""

import pytest

pytest.register_assert_rewrite("tests.damage", "tests.raw_signals")
