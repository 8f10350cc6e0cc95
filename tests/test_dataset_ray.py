"""A Ray cluster of two nodes on loopback makes the bytes that local processes make, whoever is killed meanwhile."""

import hashlib
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from imubench.dataset import on_ray
from imubench.dataset.generate import generate
from imubench.dataset.identity import identity
from imubench.dataset.manifest import MANIFEST
from imubench.dataset.shard import RECEIPTS, Job
from imubench.errors import InputError
from imubench.main import main

SPEC = """
name = "small"
seconds = 100
recordings_per_rig = 2
recordings_per_file = 2
[[rig]]
family = "hinge"
rocking_probability = 0.3
[[rig]]
family = "pendulum"
[[effect]]
name = "low_pass"
probability = 0.3
"""
COUNT = 15
MEMORY = 80 * 1024**2  # bytes of a node's object store: about the least Ray takes; receipts are small


def job(out: Path | str) -> Job:
    return Job({"spec.toml": SPEC.encode()}, 3, COUNT, str(out))


def hashes(folder: Path) -> dict[str, str]:
    """SHA-256 of every file, hidden ones too."""
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return {p.relative_to(folder).as_posix(): hashlib.sha256(p.read_bytes()).hexdigest() for p in files}


def test_without_ray_one_line_says_what_to_install(tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "ray", None)
    (tmp_path / "spec.toml").write_text(SPEC)
    out = tmp_path / "d"
    command = ["generate", str(tmp_path / "spec.toml"), "--count", "2", "--engine", "ray", "--out", str(out)]
    monkeypatch.setattr("sys.argv", ["imubench", *command])
    with pytest.raises(SystemExit) as caught:
        main()
    assert caught.value.code == 2
    said = capsys.readouterr().err
    assert "pip install 'imubench[ray]'" in said
    assert said.count("\n") == 1
    assert not out.exists()


def test_an_address_without_ray_and_ray_without_workers_are_refused(tmp_path):
    with pytest.raises(InputError, match=r"expected one with the engine ray alone, got '10.0.0.1:6379' with local"):
        generate(job(tmp_path / "d"), 0, address="10.0.0.1:6379")
    with pytest.raises(InputError, match="expected 1 or more with the engine ray, got 0"):
        generate(job(tmp_path / "d"), 0, "ray")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("key", ("versions", "code", "machine"))
def test_a_node_that_has_something_else_makes_nothing(tmp_path, key):
    asked = job(tmp_path / "d")
    with pytest.raises(InputError, match=f"ray: expected nodes with the {key} of this one, other, got "):
        on_ray._make(asked, identity(asked) | {key: "other"}, 0)
    assert not list(tmp_path.iterdir())


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    """The hashes of the dataset as one process makes it."""
    out = tmp_path_factory.mktemp("alone") / "d"
    generate(job(out), workers=1)
    return hashes(out)


@pytest.fixture(scope="module")
def cluster():
    pytest.importorskip("ray", reason="needs the extra: pip install 'imubench[ray]'")
    from ray.cluster_utils import Cluster

    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
    node = {"num_cpus": 1, "object_store_memory": MEMORY, "include_dashboard": False}
    made = Cluster(initialize_head=True, head_node_args=node)
    made.add_node(num_cpus=1, object_store_memory=MEMORY)
    yield made
    made.shutdown()


def started(cluster, out: Path, tmp_path: Path) -> subprocess.Popen:
    spec = tmp_path / "spec.toml"
    spec.write_text(SPEC)
    command = [sys.executable, "-m", "imubench", "generate", str(spec), "--count", str(COUNT), "--seed", "3"]
    return subprocess.Popen([*command, "--engine", "ray", "--address", cluster.address, "--out", str(out)])


def workers(cluster) -> dict[int, list[int]]:
    """The processes that make shards now, by node: a node's raylet is their parent."""
    found = {node.all_processes["raylet"][0].process.pid: [] for node in cluster.list_all_nodes()}
    for entry in Path("/proc").iterdir():
        try:
            parent = int((entry / "stat").read_text().rpartition(")")[2].split()[1])
            if parent in found and b"ray::_make" in (entry / "cmdline").read_bytes() and entry.name.isdigit():
                found[parent].append(int(entry.name))
        except (OSError, IndexError):
            continue
    return found


def until(condition, seconds: float = 120.0) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "it did not come to that"
        time.sleep(0.02)


needs_proc = pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="finds workers in /proc")


@pytest.mark.slow
@needs_proc
def test_two_nodes_make_the_same_bytes_as_one_and_four_processes(cluster, alone, tmp_path):
    generate(job(tmp_path / "four"), workers=4)
    assert hashes(tmp_path / "four") == alone
    run = started(cluster, tmp_path / "ray", tmp_path)
    until(lambda: all(workers(cluster).values()))  # both nodes at work
    assert run.wait(300) == 0
    assert hashes(tmp_path / "ray") == alone


@pytest.mark.slow
@needs_proc
def test_a_worker_killed_midway_loses_nothing(cluster, alone, tmp_path):
    run = started(cluster, tmp_path / "d", tmp_path)
    until(lambda: any((tmp_path / "d/samples").glob(".*.partial.*")) and any(workers(cluster).values()))
    os.kill(next(pid for pids in workers(cluster).values() for pid in pids), signal.SIGKILL)
    assert run.wait(300) == 0
    assert hashes(tmp_path / "d") == alone


@pytest.mark.slow
@needs_proc
def test_a_node_lost_midway_loses_nothing(cluster, alone, tmp_path):
    lost = cluster.add_node(num_cpus=1, object_store_memory=MEMORY)
    raylet = lost.all_processes["raylet"][0].process.pid
    run = started(cluster, tmp_path / "d", tmp_path)
    until(lambda: workers(cluster).get(raylet))
    cluster.remove_node(lost, allow_graceful=False)
    assert run.wait(300) == 0
    assert hashes(tmp_path / "d") == alone


@pytest.mark.slow
@needs_proc
def test_what_a_killed_run_finished_is_gone_on_with_by_local_processes(cluster, alone, tmp_path):
    run = started(cluster, tmp_path / "d", tmp_path)
    until(lambda: any((tmp_path / "d" / RECEIPTS).glob("0*.json")))
    run.kill()
    run.wait(30)
    until(lambda: not any(workers(cluster).values()), 60)  # Ray ends the workers of a driver that is gone
    assert not (tmp_path / "d" / MANIFEST).exists()
    told = []
    generate(job(tmp_path / "d"), 1, report=lambda what, done, total: told.append(done))
    assert told[0] > 0
    assert hashes(tmp_path / "d") == alone


@pytest.mark.slow
def test_a_cluster_that_is_not_there_is_said_in_one_line(tmp_path):
    pytest.importorskip("ray", reason="needs the extra: pip install 'imubench[ray]'")
    with pytest.raises(InputError, match=r"address: expected that of a Ray cluster, got '127.0.0.1:9'"):
        generate(job(tmp_path / "d"), 1, "ray", address="127.0.0.1:9")
