"""What is written comes back bit by bit, in CSV and in Parquet; what a laboratory writes by hand is read."""

import dataclasses
import tomllib
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from imubench.errors import InputError
from imubench.format1 import read, read_recording, read_reference, write_recording
from imubench.models import RIG_FILES
from imubench.models.tree import rig_tree
from imubench.recording import Body, Encoder, Imu, Pose, Recording
from imubench.reference import Reference
from imubench.run import simulate
from tests.calls import calls
from tests.scenarios import EVERY

TABLES = ("csv", "parquet")


def assert_same(one: object, two: object, where: str = "") -> None:
    """Compare types, numbers by their bits (NaN equals NaN), and everything within."""
    if dataclasses.is_dataclass(one):
        assert type(one) is type(two), where
        for field in dataclasses.fields(one):
            assert_same(getattr(one, field.name), getattr(two, field.name), f"{where}.{field.name}")
    elif isinstance(one, np.ndarray):
        assert isinstance(two, np.ndarray), where
        assert one.shape == two.shape, where
        unseen = np.isnan(one)
        assert np.array_equal(unseen, np.isnan(two)), where
        assert np.where(unseen, 0.0, one).tobytes() == np.where(unseen, 0.0, two).tobytes(), where
    elif isinstance(one, tuple):
        assert isinstance(two, tuple), where
        assert len(one) == len(two), where
        for i, (a, b) in enumerate(zip(one, two, strict=True)):
            assert_same(a, b, f"{where}[{i}]")
    else:
        assert repr(one) == repr(two), where


def numbers(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high, allow_nan=False)


def arrays(draw: st.DrawFn, shape: tuple[int, ...], low: float, high: float, gaps: bool = False) -> np.ndarray:
    """Any doubles in bounds, subnormal ones and -0.0 too."""
    one = numbers(low, high) | st.just(float("nan")) if gaps else numbers(low, high)
    size = int(np.prod(shape))
    return np.array(draw(st.lists(one, min_size=size, max_size=size))).reshape(shape)


def stamps(draw: st.DrawFn, n: int) -> np.ndarray:
    """Increasing times that start anywhere and stay near 100 Hz, so that no check of the rate objects."""
    start = draw(numbers(-1e3, 1e9))
    steps = np.array(draw(st.lists(numbers(0.008, 0.012), min_size=n, max_size=n)))
    return start + np.cumsum(steps)


quaternions = st.integers(0, 2**32 - 1).map(
    lambda seed: (lambda q: q / np.linalg.norm(q))(np.random.default_rng(seed).normal(size=4))
)
maybe_std = st.none() | numbers(0.0, 10.0)


@st.composite
def recordings(draw: st.DrawFn) -> tuple[Recording, Reference | None]:
    """Every field of the format, there or not; a few samples each."""
    rig = draw(st.sampled_from(sorted(RIG_FILES)))
    n = draw(st.integers(2, 6))
    time = stamps(draw, n)
    imus = tuple(
        Imu(
            name=f"imu{i + 1}",
            time=time,
            gyro=arrays(draw, (n, 3), -30, 30),
            accel=arrays(draw, (n, 3), -100, 100),
            rate=draw(numbers(50, 200)),
            gyro_noise_std=draw(maybe_std),
            accel_noise_std=draw(maybe_std),
            gyro_range=draw(st.none() | numbers(30, 100)),
            accel_range=draw(st.none() | numbers(100, 4000)),
            mount_position=arrays(draw, (3,), -1, 1),
            mount_quaternion=draw(quaternions | st.just(np.array([1.0, -0.0, 0.0, 0.0]))),
            mount_position_std=draw(maybe_std),
            mount_rotation_std=draw(maybe_std),
        )
        for i in range(draw(st.integers(1, len(rig_tree(rig).imus))))
    )
    joints = ["hinge"] * draw(st.integers(0, 2)) if rig == "hinge" else []
    encoders = tuple(
        Encoder(joint, time, arrays(draw, (n,), -6, 6), angle_noise_std=draw(maybe_std), zero=draw(numbers(-3, 3)))
        for joint in joints
    )
    poses = []
    for segment in rig_tree(rig).names[: draw(st.integers(0, 2))]:
        kinds = draw(st.sampled_from(("position", "quaternion", "both")))
        turned = np.stack([draw(quaternions) for _ in range(n)])
        turned[draw(st.lists(st.booleans(), min_size=n, max_size=n))] = np.nan
        poses.append(
            Pose(
                segment,
                time,
                position=None if kinds == "quaternion" else arrays(draw, (n, 3), -5, 5, gaps=True),
                quaternion=None if kinds == "position" else turned,
                position_noise_std=draw(maybe_std),
                rotation_noise_std=draw(maybe_std),
            )
        )
    recording = Recording(
        name=draw(st.text(st.characters(exclude_categories=["C", "Z"]), max_size=20)),
        rig=rig,
        imus=imus,
        motion=draw(st.sampled_from(("hand", "free"))),
        gravity=draw(st.just(9.81) | numbers(9.7, 9.9)),
        base=draw(st.sampled_from(("free", "fixed"))),
        base_quaternion=draw(quaternions),
        encoders=encoders,
        poses=tuple(poses),
        free_swings=((float(time[0]), float(time[-1])),) * draw(st.integers(0, 2)),
        body=draw(
            st.none()
            | st.builds(
                Body,
                numbers(1e-3, 100),
                st.tuples(*[numbers(-1, 1)] * 3).map(np.array),
                st.tuples(*[numbers(1e-9, 10)] * 3).map(np.array),
            )
        ),
    )
    return recording, _reference(draw, time)


def _reference(draw: st.DrawFn, time: np.ndarray) -> Reference | None:
    there = draw(st.sets(st.sampled_from(("hinge_angle", "quaternion1", "quaternion2", "joint_position"))))
    if not there:
        return None
    n = time.size
    made = {
        "hinge_angle": arrays(draw, (n,), -6, 6, gaps=True),
        "quaternion1": np.stack([draw(quaternions) for _ in range(n)]),
        "quaternion2": np.full((n, 4), np.nan),
        "joint_position": arrays(draw, (n, 3), -5, 5, gaps=True),
    }
    return Reference(time=time, **{key: made[key] for key in there})


@pytest.mark.parametrize("table", TABLES)
@settings(max_examples=60, deadline=None, suppress_health_check=list(HealthCheck))
@given(drawn=recordings())
def test_round_trip_is_exact(tmp_path_factory, table, drawn):
    recording, reference = drawn
    folder = tmp_path_factory.mktemp("round") / "trip"
    write_recording(recording, folder, reference, table)
    again, judge = read(folder)
    assert_same(again, recording)
    assert_same(judge, reference)


@pytest.mark.parametrize("table", TABLES)
@pytest.mark.parametrize("name", EVERY)
def test_every_scenario_round_trips(tmp_path, name, table):
    recording, _ = simulate(name, seed=5)
    write_recording(recording, tmp_path / "rec", table=table)
    assert_same(read_recording(tmp_path / "rec"), recording)
    assert read_reference(tmp_path / "rec") is None


def still(n: int = 100, **facts: object) -> Imu:
    return Imu("imu1", np.arange(n) / 100, np.zeros((n, 3)), np.tile([0, 0, 9.81], (n, 1)), rate=100.0, **facts)


def test_what_is_not_declared_is_not_written(tmp_path):
    write_recording(Recording("still", "free", (still(),)), tmp_path / "rec")
    declared = tomllib.loads((tmp_path / "rec" / "recording.toml").read_text())
    assert declared == {
        "format": 1, "name": "still", "rig": "free", "imu": [{"name": "imu1", "file": "imu1.csv", "rate": 100.0}],
    }  # fmt: skip
    assert (tmp_path / "rec" / "imu1.csv").read_text().splitlines()[0] == "time,gyr_x,gyr_y,gyr_z,acc_x,acc_y,acc_z"


def test_unseen_cells_are_empty(tmp_path):
    position = np.array([[0.25, np.nan, 0.0], [np.nan, np.nan, np.nan]])
    pose = Pose("segment1", np.array([0.0, 0.5]), position=position)
    write_recording(Recording("seen", "free", (still(),), poses=(pose,)), tmp_path / "rec")
    assert (tmp_path / "rec" / "pose1.csv").read_text() == "time,x,y,z\n0,0.25,,0\n0.5,,,\n"


EXAMPLE = """
format = 1
name = "rig-3-fast-swing"
rig = "hinge"                     # a rig of models/, or a path to an MJCF file beside this one
motion = "hand"
gravity = 9.81
base = "free"
base_quaternion = [1, 0, 0, 0]
[[imu]]
name = "imu1"
file = "imu1.csv"
rate = 100.0
gyro_noise_std = 0.002
accel_noise_std = 0.02
gyro_range = 35.0
mount_position = [-0.10, 0.0, 0.02]
mount_quaternion = [1, 0, 0, 0]
mount_position_std = 0.005
mount_rotation_std = 0.02
[[encoder]]
joint = "hinge"
file = "encoder.csv"
angle_noise_std = 0.0005
[[pose]]
segment = "segment1"
file = "pose1.csv"
position_noise_std = 0.001
rotation_noise_std = 0.005
[[free_swing]]
start = 0
end = 0.02
[body]
mass = 1.2
com = [0, 0, -0.25]
inertia = [0.03, 0.03, 0.002]
[reference]
file = "reference.csv"
"""


@pytest.fixture
def by_hand(tmp_path: Path) -> Path:
    """The contract's example, as a laboratory may write it: CRLF, a BOM, spaces, blank lines, other columns."""
    (tmp_path / "recording.toml").write_text(EXAMPLE)
    (tmp_path / "imu1.csv").write_bytes(
        b"\xef\xbb\xbftemp, acc_x,acc_y,acc_z,time,gyr_x,gyr_y,gyr_z\r\n"
        b"warm,1,2,9.5, 0.00,1e-3,-2E-2,3\r\n\r\nwarm,1,2,9,0.01,1,2,3\r\ncold,1,2,9,.02,1,2,+3\r\n\r\n"
    )
    (tmp_path / "encoder.csv").write_text('"time","angle"\n0.0,"0.5"\n0.03,0.25\n')
    (tmp_path / "pose1.csv").write_text("time,z,qw,qx,qy,qz\n0,1.5,1,0,0,0\n0.01,,,,,\n0.02,NaN,0,1,0,0")
    (tmp_path / "reference.csv").write_text("time,hinge_angle\n0.00,0.5\n0.03,\n")
    return tmp_path


def test_what_a_laboratory_writes_by_hand_is_read(by_hand):
    recording, reference = read(by_hand)
    imu = recording.imus[0]
    assert np.array_equal(imu.time, [0.0, 0.01, 0.02])
    assert np.array_equal(imu.gyro, [[1e-3, -2e-2, 3], [1, 2, 3], [1, 2, 3]])
    assert np.array_equal(imu.accel[0], [1, 2, 9.5])
    assert imu.accel_range is None
    assert np.array_equal(imu.mount_position, [-0.10, 0.0, 0.02])
    assert recording.encoders[0].angle.tolist() == [0.5, 0.25]
    position, quaternion = recording.poses[0].position, recording.poses[0].quaternion
    assert position is not None
    assert np.array_equal(position[:, 2], [1.5, np.nan, np.nan], equal_nan=True)
    assert np.isnan(position[:, :2]).all()
    assert quaternion is not None
    assert np.array_equal(quaternion[2], [0, 1, 0, 0])
    assert recording.free_swings == ((0.0, 0.02),)
    assert recording.body is not None
    assert recording.body.mass == 1.2
    assert reference is not None
    assert np.array_equal(reference.hinge_angle, [0.5, np.nan], equal_nan=True)
    assert reference.quaternion1 is None


def test_a_parquet_file_is_read_in_the_place_of_a_csv(by_hand, tmp_path_factory):
    recording, reference = read(by_hand)
    other = tmp_path_factory.mktemp("other") / "rec"
    write_recording(recording, other, reference, "parquet")
    for path in by_hand.glob("*.csv"):
        path.unlink()
    for path in other.glob("*.parquet"):
        path.rename(by_hand / path.name)
    assert_same(read(by_hand), (recording, reference))


def test_an_mjcf_file_travels_with_its_recording(tmp_path):
    rig = tmp_path / "arm.xml"
    rig.write_text("<mujoco/>")
    recording = Recording("arm", "rigs/arm.xml", (still(),))
    write_recording(recording, tmp_path / "rec", rig_file=rig)
    assert_same(read_recording(tmp_path / "rec"), recording)
    assert (tmp_path / "rec" / "rigs" / "arm.xml").read_text() == "<mujoco/>"
    with pytest.raises(InputError, match=r"expected an MJCF file as rig_file for rig 'rigs/arm\.xml', got None"):
        write_recording(recording, tmp_path / "rec2")
    with pytest.raises(InputError, match="expected no MJCF file as rig_file for rig 'free'"):
        write_recording(Recording("still", "free", (still(),)), tmp_path / "rec2", rig_file=rig)


def test_bad_output_leaves_nothing(tmp_path):
    pose = Pose("segment1", np.array([0.0, 0.5]), position=np.array([[0.0, 0, 0], [0, np.inf, 0]]))
    recording = Recording("far", "free", (still(),), poses=(pose,))
    with pytest.raises(InputError, match=r"pose1\.csv, column 'y', row 2: expected a number or NaN, got inf"):
        write_recording(recording, tmp_path / "rec")
    with pytest.raises(InputError, match="unknown table 'xlsx'; known: csv, parquet"):
        write_recording(Recording("still", "free", (still(),)), tmp_path / "rec", table="xlsx")  # type: ignore[arg-type]
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("table", TABLES)
def test_no_row_of_a_recording_is_read_by_itself(tmp_path, table):
    """More rows take hardly more calls: what is called works on whole columns and blocks of a file."""
    rng = np.random.default_rng(0)

    def written(n: int) -> Path:
        imus = tuple(
            Imu(
                name=name,
                time=np.arange(n) / 1000,
                gyro=rng.normal(size=(n, 3)),
                accel=rng.normal([0, 0, 9.81], size=(n, 3)),
                rate=1000.0,
            )
            for name in ("imu1", "imu2")
        )
        write_recording(Recording("seconds", "hinge", imus), tmp_path / str(n), table=table)
        read_recording(tmp_path / str(n))  # what is only done the first time
        return tmp_path / str(n)

    short, long = (calls(partial(read_recording, written(n))) for n in (100, 10_000))
    assert long - short < 2_000  # a call a row would be 19,800 more, blocks of a file are some hundred
