"""The tests, a package so that they may share what `damage.py` holds."""

import pytest

pytest.register_assert_rewrite("tests.damage")
