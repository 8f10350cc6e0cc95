"""A dataset at a URL has the bytes of one in a folder; nothing half-sent looks finished."""

from pathlib import Path
from uuid import uuid4

import numpy as np
import pytest

from imubench.dataset import read
from imubench.dataset.generate import generate
from imubench.dataset.manifest import MANIFEST, verify
from imubench.dataset.reading import indices
from imubench.dataset.remote import place
from imubench.dataset.shard import Job
from imubench.errors import InputError
from imubench.main import main

fsspec = pytest.importorskip("fsspec", reason="needs the extra: pip install 'imubench[remote]'")

SPEC = """
name = "small"
seconds = 5
recordings_per_rig = 2
recordings_per_file = 2
[[rig]]
family = "hinge"
"""
COUNT = 5


def job(out: Path | str, seed: int = 3) -> Job:
    return Job({"spec.toml": SPEC.encode()}, seed, COUNT, str(out))


def content(path: Path | str) -> dict[str, bytes]:
    where = place(str(path))
    return {name: where.read(name) for name in where.names()}


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    out = tmp_path_factory.mktemp("alone") / "d"
    generate(job(out), workers=0)
    return out


@pytest.fixture(params=("memory", "file"))
def url(request, tmp_path):
    return f"memory://{uuid4().hex}/d" if request.param == "memory" else f"file://{tmp_path.as_posix()}/d"


def test_the_same_bytes_at_a_url_and_read_back(alone, url):
    table = generate(job(url), workers=0)
    assert content(url) == content(alone)
    assert verify(url) == table
    assert list(indices(url)) == list(range(COUNT))
    assert np.array_equal(read(url, 3).recording.imus[0].gyro, read(alone, 3).recording.imus[0].gyro)
    assert generate(job(url), workers=0) == table
    with pytest.raises(InputError, match="got one of another seed"):
        generate(job(url, seed=4), workers=0)


@pytest.mark.long
def test_processes_send_to_a_url(alone, tmp_path):
    generate(job(f"file://{tmp_path.as_posix()}/d"), workers=2)
    assert content(tmp_path / "d") == content(alone)


def test_a_stopped_run_goes_on(alone, url):
    def stop(what: str, done: int, total: int) -> None:
        if done >= 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        generate(job(url), 0, report=stop)
    assert place(url).size(MANIFEST) is None
    with pytest.raises(InputError, match="one that is not finished: the same command goes on"):
        verify(url)
    told = []
    generate(job(url), 0, report=lambda what, done, total: told.append(done))
    assert told[0] == 2
    assert content(url) == content(alone)


@pytest.mark.parametrize("method", ("put_file", "mv"))
def test_storage_that_takes_no_data_is_said_in_one_line(alone, url, monkeypatch, method):
    with pytest.raises(KeyboardInterrupt):
        generate(job(url), 0, report=lambda *_: (_ for _ in ()).throw(KeyboardInterrupt))
    kept, system = content(url), type(place(url).system)

    def refuse(*_, **__):
        raise RuntimeError("quota exceeded\nrequest id 7")  # an error of a protocol's own

    with monkeypatch.context() as patched:
        patched.setattr(system, method, refuse)
        with pytest.raises(InputError, match=r"expected a place that can be written, got: quota exceeded$"):
            generate(job(url), 0)
    assert content(url) == kept
    generate(job(url), 0)
    assert content(url) == content(alone)


def test_storage_that_does_not_answer_is_said_in_one_line(url, monkeypatch):
    def refuse(*_, **__):
        raise RuntimeError("no credentials")

    monkeypatch.setattr(type(place(url).system), "ls", refuse)
    with pytest.raises(InputError, match="expected a place that can be listed, got: no credentials"):
        generate(job(url), 0)


def test_verify_finds_what_is_wrong_at_a_url(url, monkeypatch, capsys):
    generate(job(url), workers=0)
    where = place(url)
    first, second = (next(n for n in where.names() if n.endswith(end)) for end in ("00001.parquet", "00002.parquet"))
    where.write(first, b"X" + where.read(first)[1:])
    where.remove([second])
    with pytest.raises(InputError, match=rf"{first} \(changed\), {second} \(missing\)"):
        verify(url)
    monkeypatch.setattr("sys.argv", ["imubench", "verify", url])
    with pytest.raises(SystemExit) as caught:
        main()
    assert caught.value.code == 2
    assert f"{url}: expected the files" in capsys.readouterr().err  # the URL as it was given


def test_places_that_are_of_others_are_refused(url):
    place(url).write("thesis.tex", b"years of work")
    with pytest.raises(InputError, match="expected a new or empty folder, or a dataset, got one with 'thesis"):
        generate(job(url), 0)
    with pytest.raises(InputError, match="expected a folder to write, got a file of that name"):
        generate(job(f"{url}/thesis.tex"), 0)


@pytest.mark.parametrize("bad", ("nowhere://x/d", "s3://x/d"))
def test_urls_that_cannot_be_followed_are_refused(bad):
    if bad.startswith("s3"):
        try:
            import s3fs  # noqa: F401
        except ImportError:
            pass
        else:
            pytest.skip("s3fs is installed")
    with pytest.raises(InputError, match="expected a URL that fsspec can follow, got: "):
        generate(job(bad), 0)


def test_memory_that_processes_do_not_share_is_refused():
    with pytest.raises(InputError, match="expected a place that all workers and this process see"):
        generate(job(f"memory://{uuid4().hex}/d"), workers=1)
