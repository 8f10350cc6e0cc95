"""The same bytes whoever makes them and however often they are stopped; nothing half-written looks finished."""

import itertools
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from imubench.dataset import local
from imubench.dataset.generate import LOCK, generate
from imubench.dataset.manifest import MANIFEST, encoded, manifest, verify
from imubench.dataset.shard import RECEIPTS, Job, Receipt, finished, make_shard
from imubench.errors import InputError
from imubench.lock import locked
from imubench.main import main

SPEC = """
name = "small"
seconds = 10
recordings_per_rig = 2
recordings_per_file = 2
[[rig]]
family = "hinge"
rocking_probability = 0.3
[[rig]]
family = "pendulum"
[[motion]]
kind = "random"
[[motion]]
kind = "olsson2020"
[[effect]]
name = "low_pass"
probability = 0.3
"""
COUNT = 11
SLOW = SPEC.replace("seconds = 10", "seconds = 200")  # some seconds a shard, so that a kill meets workers at work


def job(out: Path, seed: int = 3, count: int = COUNT, text: str = SPEC) -> Job:
    return Job({"spec.toml": text.encode()}, seed, count, str(out))


def hashes(folder: Path) -> dict[str, bytes]:
    """Every file's content, hidden ones too."""
    return {p.relative_to(folder).as_posix(): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def part(folder: Path, number: int) -> Path:
    """The file of a shard that has one rig, and so one split."""
    (found,) = folder.glob(f"*-{number:05d}.parquet")
    return found


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    """The dataset as one process makes it, in order."""
    out = tmp_path_factory.mktemp("alone") / "d"
    generate(job(out), workers=0)
    return out


def test_what_is_there_at_the_end(alone):
    table = json.loads((alone / MANIFEST).read_text())
    assert sum(table["recordings"].values()) == COUNT
    assert table["samples"] == COUNT * 1000
    assert set(hashes(alone)) == {MANIFEST, *table["files"]}
    assert (alone / "spec/spec.toml").read_text() == SPEC
    assert verify(str(alone)) == table


@pytest.mark.long
@pytest.mark.parametrize("workers", (1, 4))
def test_the_same_bytes_from_any_number_of_processes(alone, tmp_path, workers):
    generate(job(tmp_path / "d"), workers)
    assert hashes(tmp_path / "d") == hashes(alone)


def test_the_same_bytes_in_any_order_and_after_a_stop(alone, tmp_path):
    asked = job(tmp_path / "d")

    def stop_midway(what: str, done: int, total: int) -> None:
        if done >= 4:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        generate(asked, 0, report=stop_midway)
    assert not (tmp_path / "d" / MANIFEST).exists()
    assert [finished(asked, n) is not None for n in range(6)] == [True, True, False, False, False, False]
    for number in (5, 3):
        make_shard(asked, number)
    told = []
    generate(asked, 0, report=lambda what, done, total: told.append((done, total)))
    assert told[0] == (4 + 1 + 2, COUNT)  # the last shard holds one recording
    assert hashes(tmp_path / "d") == hashes(alone)


def test_the_manifest_is_the_same_in_whatever_order_the_shards_were_finished(tmp_path):
    """Seconds that no binary fraction holds: a running sum of them depends on the order."""
    asked = job(tmp_path / "d", count=8)
    receipts = [Receipt(n, 2, 200, seconds, {"train": 2}, {}) for n, seconds in enumerate((0.1, 0.2, 0.3, 10.7))]
    written = {encoded(manifest(asked, order)) for order in itertools.permutations(receipts)}
    assert len(written) == 1


def test_a_finished_dataset_is_left_as_it_is(alone, tmp_path):
    shutil.copytree(alone, tmp_path / "d")
    before = {p: p.stat().st_mtime_ns for p in (tmp_path / "d").rglob("*")}
    assert sum(generate(job(tmp_path / "d"), 0)["recordings"].values()) == COUNT
    assert {p: p.stat().st_mtime_ns for p in (tmp_path / "d").rglob("*")} == before


@pytest.mark.parametrize("when", ("finished", "begun"))
@pytest.mark.parametrize(
    ("other", "message"),
    [
        ({"seed": 4}, r"got one of another seed \(seed 3, now 4\)"),
        ({"count": 12}, r"got one of another count \(count 11, now 12\)"),
        ({"text": SPEC + "\n# changed\n"}, "got one of another spec"),
    ],
)
def test_another_job_in_a_used_folder_is_refused(alone, tmp_path, when, other, message):
    out = tmp_path / "d"
    if when == "finished":
        shutil.copytree(alone, out)
    else:
        with pytest.raises(KeyboardInterrupt):
            generate(job(out), 0, report=lambda *_: (_ for _ in ()).throw(KeyboardInterrupt))
    before = hashes(out)
    with pytest.raises(InputError, match=message):
        generate(job(out, **other), 0)
    assert hashes(out).items() >= {k: v for k, v in before.items() if k != LOCK}.items()


def test_folders_of_something_else_are_refused(tmp_path):
    (tmp_path / "thesis.tex").write_text("years of work")
    with pytest.raises(InputError, match="expected a new or empty folder, or a dataset, got one with 'thesis"):
        generate(job(tmp_path), 0)
    with pytest.raises(InputError, match="expected a folder to write, got a file of that name"):
        generate(job(tmp_path / "thesis.tex"), 0)
    assert hashes(tmp_path) == {"thesis.tex": b"years of work"}


def test_two_runs_into_one_folder_are_refused(tmp_path):
    (tmp_path / "d" / LOCK).parent.mkdir(parents=True)
    with (
        locked(tmp_path / "d" / LOCK, "d"),
        pytest.raises(InputError, match=f"no other run writes to, got one in use by process {os.getpid()}"),
    ):
        generate(job(tmp_path / "d"), 0)
    generate(job(tmp_path / "d", count=1), 0)  # the lock is gone with its holder


def test_a_shard_whose_file_is_gone_or_cut_is_made_again(alone, tmp_path):
    asked = job(tmp_path / "d")
    with pytest.raises(KeyboardInterrupt):
        generate(asked, 0, report=lambda w, done, t: (_ for _ in ()).throw(KeyboardInterrupt) if done == 8 else None)
    part(tmp_path / "d/samples", 0).write_bytes(b"PAR1")
    part(tmp_path / "d/recordings", 1).unlink()
    (tmp_path / "d/samples/.1234abcd.partial.train-00002.parquet").write_bytes(b"half")
    generate(asked, 0)
    assert hashes(tmp_path / "d") == hashes(alone)


def started(out: Path, spec: Path, workers: int = 2) -> subprocess.Popen:
    command = [sys.executable, "-m", "imubench", "generate", str(spec), "--count", str(COUNT), "--seed", "3"]
    return subprocess.Popen(
        [*command, "--workers", str(workers), "--out", str(out)],
        start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # shells have jobs in the background ignore it
    )


def until(condition, seconds: float = 60.0) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "it did not come to that"
        time.sleep(0.02)


def children(pid: int) -> list[int]:
    """The workers of a run: its children but Python's own watcher of shared resources."""
    found = []
    for entry in Path("/proc").iterdir():
        try:
            stat = (entry / "stat").read_text().rpartition(")")[2].split()
            if entry.name.isdigit() and int(stat[1]) == pid and b"spawn_main" in (entry / "cmdline").read_bytes():
                found.append(int(entry.name))
        except (OSError, IndexError):
            continue
    return found


def alive(pid: int) -> bool:
    try:
        return (Path("/proc") / str(pid) / "stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.fixture
def slow(tmp_path):
    spec = tmp_path / "spec.toml"
    spec.write_text(SLOW)
    return spec


@pytest.fixture(scope="module")
def slow_alone(tmp_path_factory):
    out = tmp_path_factory.mktemp("alone") / "slow"
    generate(job(out, text=SLOW), workers=0)
    return out


needs_proc = pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="finds processes in /proc")


@pytest.mark.slow
@needs_proc
def test_a_worker_killed_midway_loses_nothing(slow_alone, tmp_path, slow):
    run = started(tmp_path / "d", slow)
    until(lambda: any((tmp_path / "d" / "samples").glob(".*.partial.*")))
    os.kill(children(run.pid)[0], signal.SIGKILL)
    assert run.wait(120) == 0
    assert hashes(tmp_path / "d") == hashes(slow_alone)


@pytest.mark.slow
@needs_proc
@pytest.mark.parametrize("how", (signal.SIGKILL, signal.SIGINT, signal.SIGTERM))
def test_a_run_killed_midway_goes_on_and_its_workers_end_with_it(slow_alone, tmp_path, slow, how):
    run = started(tmp_path / "d", slow)
    until(lambda: (tmp_path / "d" / RECEIPTS).is_dir() and any((tmp_path / "d" / RECEIPTS).glob("0*.json")))
    workers = children(run.pid)
    run.send_signal(how)
    assert run.wait(30) != 0
    until(lambda: not any(alive(pid) for pid in workers), 10)
    assert not (tmp_path / "d" / MANIFEST).exists()
    assert started(tmp_path / "d", slow).wait(120) == 0
    assert hashes(tmp_path / "d") == hashes(slow_alone)


def test_workers_that_always_die_are_given_up_with_one_line(tmp_path, monkeypatch):
    monkeypatch.setattr(local, "_pooled", _dying)
    with pytest.raises(
        InputError, match="expected workers that live, got 3 deaths in a row while shards 0, 1 were made"
    ):
        generate(job(tmp_path / "d"), 2)


def _dying(*_):
    raise local.WorkerError("killed")
    yield


def unprivileged() -> list[str]:
    """How to start a process that permissions bind, whoever runs the tests."""
    if os.getuid():
        return []
    return ["setpriv", "--bounding-set", "-dac_override,-dac_read_search"]


def runs(*command: str) -> bool:
    return bool(shutil.which(command[0])) and not subprocess.run(command, capture_output=True, check=False).returncode


@pytest.mark.skipif(os.name == "nt" or not runs(*unprivileged(), "true"), reason="needs permissions that bind")
def test_a_place_without_permission_is_said_in_one_line(tmp_path):
    (tmp_path / "spec.toml").write_text(SPEC)
    (tmp_path / "shut").mkdir(mode=0o500)
    command = [sys.executable, "-m", "imubench", "generate", str(tmp_path / "spec.toml"), "--count", "2"]
    command += ["--workers", "0", "--out", str(tmp_path / "shut" / "d")]
    done = subprocess.run([*unprivileged(), *command], capture_output=True, text=True, timeout=120)
    assert done.returncode == 2
    assert "d: expected a place that can be written, got: Permission denied" in done.stderr
    assert done.stderr.count("\n") == 1
    assert not any((tmp_path / "shut").iterdir())


SMALL_DISK = """
mount -t tmpfs -o size=600k tmpfs {at} || exit 77
{run} --out {at}/d 2> {at}.err; echo $? > {at}.rc
{python} -c "import sys; from imubench.dataset.manifest import verify; verify(sys.argv[1])" {at}/d 2> {at}.verify
ls -A {at}/d/samples > {at}.left
mount -o remount,size=50m {at}
{run} --out {at}/d && cp -r {at}/d {at}-kept
"""


@pytest.mark.slow
@pytest.mark.skipif(not runs("unshare", "-rm", "true"), reason="needs mounts of its own")
@pytest.mark.parametrize("workers", (0, 2))
def test_a_small_disk_fills_what_is_finished_stays_and_a_larger_one_goes_on(alone, tmp_path, workers):
    disk, spec = tmp_path / "disk", tmp_path / "spec.toml"
    disk.mkdir()
    spec.write_text(SPEC)
    run = f"{sys.executable} -m imubench generate {spec} --count {COUNT} --seed 3 --workers {workers}"
    script = SMALL_DISK.format(at=disk, run=run, python=sys.executable)
    done = subprocess.run(["unshare", "-rm", "sh", "-c", script], capture_output=True, text=True, timeout=120)
    if done.returncode == 77:
        pytest.skip(f"needs a tmpfs: {done.stderr.strip()}")
    assert done.returncode == 0, done.stderr
    said = Path(f"{disk}.err").read_text()
    assert Path(f"{disk}.rc").read_text() == "2\n"
    assert "expected a place that can be written, got: No space left on device" in said
    assert said.count("\n") == 1
    assert "not finished: the same command goes on" in Path(f"{disk}.verify").read_text()
    left = Path(f"{disk}.left").read_text().split()
    assert left
    assert all(name.startswith("part-") for name in left)
    assert hashes(Path(f"{disk}-kept")) == hashes(alone)


@pytest.mark.long
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs Linux' always full device")
@pytest.mark.parametrize("workers", (0, 2))
def test_a_full_disk_is_said_in_one_line_and_what_is_finished_stays(alone, tmp_path, workers):
    out = tmp_path / "d"
    with pytest.raises(KeyboardInterrupt):
        generate(job(out), 0, report=lambda w, done, t: (_ for _ in ()).throw(KeyboardInterrupt) if done == 4 else None)
    limited = (
        "import resource, sys\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (120_000, 120_000))\n"  # a shard needs more: as on a full disk
        "import signal; signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        "from imubench.main import main\nmain()\n"
    )
    (tmp_path / "spec.toml").write_text(SPEC)
    command = ["generate", str(tmp_path / "spec.toml"), "--count", str(COUNT), "--seed", "3", "--out", str(out)]
    done = subprocess.run(
        [sys.executable, "-c", limited, *command, "--workers", str(workers)],
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 2
    assert "expected a place that can be written, got" in done.stderr
    assert done.stderr.count("\n") == 1
    assert not [name for name in hashes(out) if ".partial." in name]
    generate(job(out), 0)
    assert hashes(out) == hashes(alone)


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda p: p.write_bytes(p.read_bytes()[:-1]), r"-00002.parquet \(\d+ bytes, not \d+\)"),
        (lambda p: p.write_bytes(b"X" + p.read_bytes()[1:]), r"-00002.parquet \(changed\)"),
        (lambda p: p.unlink(), r"-00002.parquet \(missing\)"),
        (lambda p: p.with_name("test-00099.parquet").write_bytes(b""), r"test-00099.parquet \(not of this dataset\)"),
    ],
)
def test_verify_finds_what_is_wrong_by_name(alone, tmp_path, spoil, message, monkeypatch, capsys):
    shutil.copytree(alone, tmp_path / "d")
    spoil(part(tmp_path / "d/samples", 2))
    with pytest.raises(InputError, match=message):
        verify(str(tmp_path / "d"))
    monkeypatch.setattr("sys.argv", ["imubench", "verify", str(tmp_path / "d")])
    with pytest.raises(SystemExit) as caught:
        main()
    assert caught.value.code == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_verify_says_when_a_dataset_is_not_finished(tmp_path):
    with pytest.raises(KeyboardInterrupt):
        generate(job(tmp_path / "d"), 0, report=lambda *_: (_ for _ in ()).throw(KeyboardInterrupt))
    with pytest.raises(InputError, match="one that is not finished: the same command goes on"):
        verify(str(tmp_path / "d"))


def test_an_unknown_engine_names_the_known_ones(tmp_path):
    with pytest.raises(InputError, match="unknown engine 'cloud'; known: local"):
        generate(job(tmp_path / "d"), 0, engine="cloud")
