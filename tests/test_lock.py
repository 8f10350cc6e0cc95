"""A lock file is held by one, and gone however its holder ends."""

import os

import pytest

from imubench.errors import InputError
from imubench.lock import locked


def test_a_second_holder_is_refused_and_takes_nothing_away(tmp_path):
    path = tmp_path / "out.lock"
    with locked(path, "out"):
        with pytest.raises(InputError, match=f"in use by process {os.getpid()}$"), locked(path, "out"):
            pass
        assert path.read_text() == f"{os.getpid()}\n"
    assert not path.exists()


@pytest.mark.parametrize("when", ["opened", "locked"])
def test_a_signal_before_it_is_noted_leaves_no_file(when, tmp_path, monkeypatch):
    """Python asks for signals between a call and what its result is put into."""
    path, opened, samestat = tmp_path / "out.lock", os.open, os.path.samestat

    def interrupted(path, flags, *mode):
        handle = opened(path, flags, *mode)
        if flags & os.O_CREAT:
            os.close(handle)
            raise KeyboardInterrupt
        return handle

    def asked(a, b):
        monkeypatch.setattr(os.path, "samestat", samestat)
        raise KeyboardInterrupt

    if when == "opened":
        monkeypatch.setattr(os, "open", interrupted)
    else:
        monkeypatch.setattr(os.path, "samestat", asked)
    with pytest.raises(KeyboardInterrupt), locked(path, "out"):
        pass
    assert not path.exists()
