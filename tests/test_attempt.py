"""Whatever an estimator does wrong is its result: a crash, a hang, NaN, a wrong shape or quantity, a dead process."""

import re
import subprocess
import sys
from pathlib import Path
from textwrap import dedent

import numpy as np
import pytest

from imubench.attempt import Failed, attempted, running_apart
from imubench.estimate import Estimate
from imubench.estimators import ESTIMATORS, Estimator
from imubench.plugins import find_estimator
from imubench.recording import Imu, Recording

FILE = """
    import numpy as np
    from imubench.errors import InputError
    from imubench.estimate import Estimate

    AXES = np.eye(3)[:2]

    def axes(value=AXES, **more):
        return Estimate("joint_axis", "mine", value, None, "not worked out", **more)

    def sound(recording): return axes()
    def crash(recording): return 1 / len(recording.poses)
    def inside_numpy(recording): return np.linalg.inv(np.zeros((2, 2)))
    def leave(recording): raise SystemExit(0)
    def hang(recording):
        while True: pass
    def die(recording):
        import os
        os._exit(1)
    def nan(recording): return axes(np.nan * AXES)
    def long(recording): return axes(2 * AXES)
    def flat(recording): return axes(AXES[:, :2])
    def one(recording): return axes(AXES[:1])
    def covariance(recording): return Estimate("joint_axis", "mine", AXES, np.eye(3))
    def status(recording): return axes(status="fine")
    def quantity(recording): return Estimate("axis", "mine", AXES, None, "not worked out")
    def infinite(recording): return axes(details={"cost": np.inf})
    def words(recording): return axes(details={"cost": "low"})
    def vector(recording): return Estimate("joint_vector", "mine", AXES, None, "not worked out")
    vector.quantity = "joint_axis"
    def nothing(recording): pass
    def refuse(recording): raise InputError("r: expected an encoder, got none")
    def lasting(recording): return axes(details={"hook": 1.0, "free": AXES.sum()})
"""


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("mine") / "mine.py"
    path.write_text(dedent(FILE))
    return path


def recording(rig: str = "hinge") -> Recording:
    rng = np.random.default_rng(0)
    stamps = np.arange(50) / 100
    count = 2 if rig == "hinge" else 1
    imus = [Imu(f"imu{i + 1}", stamps, *rng.normal(size=(2, 50, 3)), 100.0) for i in range(count)]
    return Recording("r", rig, tuple(imus))


BROKEN = [
    ("crash", "crashed", r"^ZeroDivisionError: division by zero \(mine.py, line \d+\)$"),
    ("inside_numpy", "crashed", r"^LinAlgError: Singular matrix \(mine.py, line \d+\)$"),
    ("leave", "crashed", r"^SystemExit: 0 \(mine.py, line \d+\)$"),
    ("nan", "malformed", "mine.value: expected finite numbers"),
    ("long", "malformed", "mine.value: expected unit vectors"),
    ("flat", "malformed", r"mine.value: expected shape \(n, 3\), got \(2, 2\)"),
    ("one", "malformed", "value: expected 2 rows, one for each IMU, got 1"),
    ("covariance", "malformed", r"mine.covariance: expected shape \(6, 6\), got \(3, 3\)"),
    ("status", "malformed", "unknown status of mine 'fine'; known: converged"),
    ("quantity", "malformed", "unknown quantity of mine 'axis'; known: joint_axis"),
    ("infinite", "malformed", "details: expected finite numbers by name, got 'cost': inf"),
    ("words", "malformed", "details: expected finite numbers by name, got 'cost': 'low'"),
    ("vector", "malformed", "expected a joint_axis, as it declares, got a joint_vector"),
    ("nothing", "malformed", "expected an Estimate, got None"),
    ("refuse", "refused", "^r: expected an encoder, got none$"),
]


@pytest.mark.parametrize(("function", "status", "why"), BROKEN, ids=[b[0] for b in BROKEN])
def test_what_goes_wrong_is_the_result(path, function, status, why):
    found = attempted(find_estimator(f"{path}:{function}"), recording())
    assert isinstance(found, Failed)
    assert (found.estimator, found.status) == (f"{path}:{function}", status)
    assert re.search(why, found.why), found.why
    assert "\n" not in found.why
    assert ("line" in found.trace) == (status == "crashed")


def test_an_axis_of_a_rig_without_one(path):
    found = attempted(find_estimator(f"{path}:one"), recording("pendulum"))
    assert isinstance(found, Failed)
    assert found.why.endswith("expected a joint_vector, as rig pendulum has no axis, got a joint_axis")


def test_what_is_sound_is_left_alone(path):
    answer = attempted(find_estimator(f"{path}:lasting"), recording())
    assert isinstance(answer, Estimate)
    np.testing.assert_array_equal(answer.value, np.eye(3)[:2])
    ours = ESTIMATORS["olsson2020"]
    np.testing.assert_array_equal(attempted(ours, recording()).value, ours.estimate(recording()).value)  # the same code


@pytest.mark.long
def test_ours_and_one_that_no_process_can_be_sent(path):
    ours = ESTIMATORS["seel2012"]
    with running_apart() as apart:
        answer = attempted(ours, recording(), 30.0, apart)
        np.testing.assert_allclose(answer.value, ours.estimate(recording()).value, atol=1e-9)  # threads of BLAS differ
        here_alone = Estimator("alone", "", None, 0, lambda recording: answer, "")
        found = attempted(here_alone, recording(), 30.0, apart)
        assert isinstance(found, Failed)
        assert found.status == "malformed"
        assert found.why.startswith("expected what another process can load, got ")


@pytest.mark.long
def test_a_process_apart_outlives_what_hangs_and_dies_in_it(path):
    """One process for all: each start costs a second or so."""
    with running_apart() as apart:
        for function, status in (("sound", None), ("die", "crashed"), ("crash", "crashed"), ("hang", "timed out")):
            found = attempted(find_estimator(f"{path}:{function}"), recording(), 2.0, apart)
            assert (found.status if isinstance(found, Failed) else None) == status, found
        assert found.why == "no answer after 2 s"
        answer = attempted(find_estimator(f"{path}:sound"), recording(), 10.0, apart)
    assert isinstance(answer, Estimate)


@pytest.mark.long
def test_a_worker_that_is_killed_leaves_the_semaphores_of_its_process_apart_unsaid(tmp_path):
    """Python's resource tracker removes them, and would warn of them behind the one line that a command says."""
    program = tmp_path / "killed.py"
    program.write_text(
        dedent("""
        import time
        from pathlib import Path

        from imubench.attempt import attempted, own_apart
        from imubench.estimators import ESTIMATORS
        from imubench.workers import process_pool

        def work(ready):
            attempted(ESTIMATORS["seel2012"], None, 60.0, own_apart())
            ready.touch()
            time.sleep(60)

        if __name__ == "__main__":
            with process_pool(1) as pool:
                ready = Path(__file__).with_name("ready")
                pool.submit(work, ready)
                while not ready.exists():
                    time.sleep(0.01)
                raise SystemExit(3)
        """)
    )
    ended = subprocess.run([sys.executable, program], capture_output=True, text=True, timeout=120, check=False)
    assert (ended.returncode, ended.stdout, ended.stderr) == (3, "", "")
