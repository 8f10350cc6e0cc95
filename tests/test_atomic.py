"""Output is complete or absent, and nothing that is not ours is ever replaced."""

from pathlib import Path

import pytest

from imubench import atomic
from imubench.atomic import MARKER, atomic_directory, atomic_file
from imubench.errors import InputError


def make(path: Path, text: str = "new") -> None:
    with atomic_directory(path) as folder:
        (folder / "inner").mkdir()
        (folder / "inner" / "result.txt").write_text(text)


def everything(folder: Path) -> list[str]:
    return sorted(p.relative_to(folder).as_posix() for p in folder.rglob("*"))


def test_a_folder_appears_whole_with_parents(tmp_path):
    out = tmp_path / "a" / "b"
    with atomic_directory(out) as folder:
        (folder / "result.txt").write_text("1")
        assert not out.exists()
        assert folder.parent == out.parent  # a sibling: the same file system, so a rename suffices
    assert everything(tmp_path) == ["a", "a/b", f"a/b/{MARKER}", "a/b/result.txt"]


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt, SystemExit])
def test_an_error_leaves_nothing_not_even_new_parents(tmp_path, error):
    with pytest.raises(error), atomic_directory(tmp_path / "a" / "b") as folder:
        (folder / "half.txt").write_text("1")
        raise error
    assert everything(tmp_path) == []


def test_an_error_keeps_what_was_there(tmp_path):
    out = tmp_path / "out"
    make(out, "old")
    before = everything(tmp_path)
    with pytest.raises(RuntimeError), atomic_directory(out) as folder:
        (folder / "half.txt").write_text("1")
        raise RuntimeError
    assert everything(tmp_path) == before
    assert (out / "inner" / "result.txt").read_text() == "old"


def test_our_own_folder_and_an_empty_one_are_replaced(tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    make(out, "old")
    with atomic_directory(out) as folder:
        (folder / "other.txt").write_text("new")
    assert everything(tmp_path) == ["out", f"out/{MARKER}", "out/other.txt"]


def test_a_folder_of_folders_is_replaced_too(tmp_path):
    for _ in range(2):
        with atomic_directory(tmp_path / "run") as folder:
            make(folder / "recording")
            make(folder / "recording")
    assert (tmp_path / "run" / "recording" / "inner" / "result.txt").exists()


def test_a_folder_written_into_itself_is_complete(tmp_path):
    with atomic_directory(tmp_path / "out") as folder:
        make(folder)  # what `convert` does with a single recording
    assert everything(tmp_path) == ["out", f"out/{MARKER}", "out/inner", "out/inner/result.txt"]
    make(tmp_path / "out")


def test_a_foreign_folder_is_refused(tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "thesis.txt").write_text("years of work")
    message = r"out: expected a new or empty folder, or one as imubench left it, got one with a foreign file 'thesis"
    with pytest.raises(InputError, match=message):
        make(tmp_path / "out")
    assert everything(tmp_path) == ["out", "out/thesis.txt"]


def test_a_file_added_to_ours_is_kept(tmp_path):
    make(tmp_path / "out")
    (tmp_path / "out" / "notes.txt").write_text("mine")
    with pytest.raises(InputError, match=r"a foreign file 'notes\.txt'"):
        make(tmp_path / "out")
    assert (tmp_path / "out" / "notes.txt").read_text() == "mine"


def test_an_edit_of_ours_is_kept(tmp_path):
    make(tmp_path / "out")
    file = tmp_path / "out" / "inner" / "result.txt"
    file.write_text("edited by hand")
    with pytest.raises(InputError, match=r"a changed file 'inner/result\.txt'"):
        make(tmp_path / "out")
    assert file.read_text() == "edited by hand"


def test_a_file_added_while_we_write_is_kept(tmp_path):
    make(tmp_path / "out")
    with pytest.raises(InputError, match=r"a foreign file 'late\.txt'"), atomic_directory(tmp_path / "out"):
        (tmp_path / "out" / "late.txt").write_text("mine")
    assert list(tmp_path.iterdir()) == [tmp_path / "out"]
    assert (tmp_path / "out" / "late.txt").read_text() == "mine"


def test_a_marker_that_is_no_listing_of_ours_protects(tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / MARKER).write_text('["thesis.txt"]')
    (tmp_path / "out" / "thesis.txt").write_text("years of work")
    with pytest.raises(InputError, match=r"a foreign file 'thesis\.txt'"):
        make(tmp_path / "out")


def test_the_old_folder_comes_back_when_the_renaming_fails_where_names_cannot_be_exchanged(tmp_path, monkeypatch):
    monkeypatch.setattr(atomic, "_exchanged", lambda one, other: False)
    make(tmp_path / "out", "older")
    make(tmp_path / "out", "old")
    rename = Path.rename

    def failing(self: Path, target: Path) -> Path:
        if self.name.endswith(".partial"):
            raise OSError(28, "No space left on device")
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", failing)
    with pytest.raises(InputError, match="out: expected a place that can be written, got: No space left on device"):
        make(tmp_path / "out", "new")
    assert list(tmp_path.iterdir()) == [tmp_path / "out"]
    assert (tmp_path / "out" / "inner" / "result.txt").read_text() == "old"


def test_a_file_where_the_folder_should_be_is_refused(tmp_path):
    (tmp_path / "out").write_text("mine")
    with pytest.raises(InputError, match="out: expected a folder to write, got a file of that name"):
        make(tmp_path / "out")
    with pytest.raises(InputError, match="expected a place that can be written, got: "):
        make(tmp_path / "out" / "below")
    assert (tmp_path / "out").read_text() == "mine"


def test_the_current_folder_is_refused(tmp_path, monkeypatch):
    (tmp_path / "below").mkdir()
    monkeypatch.chdir(tmp_path / "below")
    for path in (Path(), Path("..")):
        with pytest.raises(InputError, match="expected a folder of its own for the output"):
            make(path)


def test_a_link_stays_a_link(tmp_path):
    make(tmp_path / "real", "old")
    (tmp_path / "link").symlink_to("real")
    make(tmp_path / "link", "new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real" / "inner" / "result.txt").read_text() == "new"


def test_a_file_is_replaced_at_the_end_and_keeps_its_suffix(tmp_path):
    path = tmp_path / "new" / "run.rrd"
    for text in ("old", "new"):
        with atomic_file(path) as partial:
            assert partial.suffix == ".rrd"
            partial.write_text(text)
            assert not path.exists() or path.read_text() == "old"
        assert path.read_text() == text
    assert everything(tmp_path) == ["new", "new/run.rrd"]


def test_an_error_keeps_the_old_file(tmp_path):
    path = tmp_path / "score.json"
    path.write_text("old")
    with pytest.raises(RuntimeError), atomic_file(path) as partial:
        partial.write_text("half")
        raise RuntimeError
    assert everything(tmp_path) == ["score.json"]
    assert path.read_text() == "old"


def test_a_folder_where_the_file_should_be_is_refused(tmp_path):
    with pytest.raises(InputError, match="expected a file to write, got a folder"), atomic_file(tmp_path):
        pass


@pytest.mark.parametrize("older", (True, False))
def test_files_that_belong_together_have_their_names_all_or_none(older, tmp_path, monkeypatch):
    first, last = tmp_path / "sealed.json", tmp_path / "commitment.json"
    if older:
        first.write_text("old")
        last.write_text("old")
    before = everything(tmp_path)
    replace = Path.replace

    def failing(self: Path, target: Path) -> Path:
        if target == last:
            raise OSError(28, "No space left on device")
        return replace(self, target)

    monkeypatch.setattr(Path, "replace", failing)
    with (
        pytest.raises(InputError, match=r"expected a place that can be written, got: No space left on device"),
        atomic.atomic_files(first, last) as parts,
    ):
        for part in parts:
            part.write_text("new")
    assert everything(tmp_path) == before
    assert all(path.read_text() == "old" for path in (first, last) if older)
    monkeypatch.undo()
    with atomic.atomic_files(first, last) as parts:
        for part in parts:
            part.write_text("new")
    assert [path.read_text() for path in (first, last)] == ["new", "new"]
    assert everything(tmp_path) == ["commitment.json", "sealed.json"]


def test_what_a_killed_run_left_is_removed_and_what_it_had_moved_aside_comes_back(tmp_path):
    make(tmp_path / "out", "old")
    (tmp_path / "out").rename(tmp_path / ".out.0123abcd.old")
    for name in (".out.01234567.partial", "..out.01234567.partial.89abcdef.partial"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "half").write_text("1")
    for name in (".out.lock", "..out.01234567.partial.lock"):
        (tmp_path / name).write_text("99999\n")
    others = (".out.parts", ".other.01234567.partial", ".out.0123.partial")
    for name in others:
        (tmp_path / name).mkdir()
    with pytest.raises(RuntimeError), atomic_directory(tmp_path / "out"):
        raise RuntimeError
    assert {p.name for p in tmp_path.iterdir()} == {"out", *others}
    assert (tmp_path / "out" / "inner" / "result.txt").read_text() == "old"


@pytest.mark.parametrize("before", [None, "old"])
def test_a_signal_right_after_the_first_of_two_files_has_its_name_takes_it_back(before, tmp_path, monkeypatch):
    first, last = tmp_path / "a.json", tmp_path / "b.json"
    if before is not None:
        first.write_text(before)
    name = atomic._name

    def interrupted(partial: Path, target: Path) -> None:
        name(partial, target)
        raise KeyboardInterrupt

    monkeypatch.setattr(atomic, "_name", interrupted)
    with pytest.raises(KeyboardInterrupt), atomic.atomic_files(first, last) as parts:
        for part in parts:
            part.write_text("new")
    assert everything(tmp_path) == ([] if before is None else ["a.json"])
    assert before is None or first.read_text() == before
