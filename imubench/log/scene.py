"""The 3D scene of a run in Rerun: segments, IMUs, the true and the estimated joint."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import rerun as rr
from rerun.components import FillMode

from imubench.arrays import Array
from imubench.estimate import Estimate
from imubench.log.joint import joint_arrows, log_arrow
from imubench.log.signals import XYZ, drawn_rows, time_column
from imubench.models.tree import Tree
from imubench.recording import Imu, Recording
from imubench.reference import Reference
from imubench.rotations import conjugate, from_axis_angle, multiply, rotate, rotate_back
from imubench.truth import Truth

FLAT_CASE = (0.058, 0.034, 0.015)  # m, an MTw along the sensor axes, of an IMU that no file has
JOINT = (70, 75, 85)
TRAVEL = 0.3  # m; a joint that travels farther is followed
SHORTEST = 0.12  # m, of a segment without an IMU
AT_REST = "no pose measured: drawn at rest"
SEGMENT_COLOURS = {"segment1": (115, 140, 165), "segment2": (165, 178, 128)}
RADII = {True: 0.018, False: 0.045}  # m, of a segment on a hinge, or of a limb


@dataclass(frozen=True)
class Motion:
    """The pose of a frame in its parent; one row: it does not move."""

    time: Array  # (n,) s
    position: Array  # (n, 3) m
    quaternion: Array  # (n, 4) frame -> parent

    @property
    def still(self) -> bool:
        """Whether no row differs from the first by more than rounding."""
        turned = np.minimum(np.abs(self.quaternion - self.quaternion[0]), np.abs(self.quaternion + self.quaternion[0]))
        return bool(np.ptp(self.position, axis=0).max() < 1e-9 and turned.max() < 1e-9)


STILL = Motion(np.zeros(1), np.zeros((1, 3)), np.array([[1.0, 0, 0, 0]]))


@dataclass(frozen=True)
class Scene:
    """What a camera must know about the scene."""

    source: str  # where the poses come from
    frame: str  # path of the frame to look at it from: the world, or one that travels with the rig
    middle: Array  # (3,) m, of the rig, in that frame
    facing: Array  # (3,) the mean direction, world, that should point to the eye's side: hinge axis, or side of the IMU
    reach: float  # m, half the size of the rig


def segment_motions(
    recording: Recording, truth: Truth | None, reference: Reference | None
) -> tuple[dict[str, Motion], str]:
    """Return the pose of each segment in the world at about 60 Hz, and where it comes from.

    The best source that there is: the truth, the reference, measured poses, an encoder on
    the declared base; else the rig stands still at joint angle 0. Rows not seen are left out.
    """
    if truth is not None:
        rows = drawn_rows(truth.time)
        time = truth.time[rows]
        return {s.name: Motion(time, s.position[rows], s.quaternion[rows]) for s in truth.segments}, "true motion"
    found: dict[str, Motion] = {}
    if reference is not None:
        for name, q in (("segment1", reference.quaternion1), ("segment2", reference.quaternion2)):
            if q is not None and (motion := _seen(reference.time, reference.joint_position, q)) is not None:
                found[name] = motion
    if found:
        return found, "motion from the reference"
    for pose in recording.poses:
        if (motion := _seen(pose.time, pose.position, pose.quaternion)) is not None:
            found[pose.segment] = motion
    if found:
        return found, "measured poses"
    start = np.array([recording.imus[0].time[0] if recording.imus else 0.0])
    base = recording.base_quaternion
    found = {name: Motion(start, np.zeros((1, 3)), base[None]) for name in (recording.tree.names or ("segment1",))}
    if recording.tree.hinge is not None and recording.encoders:
        encoder = recording.encoders[0]
        rows = drawn_rows(encoder.time)
        turn = from_axis_angle(recording.tree.hinge.axis, encoder.angle[rows] + encoder.zero)
        found[recording.tree.last.name] = Motion(encoder.time[rows], np.zeros((rows.size, 3)), multiply(base, turn))
        return found, "hinge angle from the encoder"
    return found, AT_REST


def _seen(time: Array, position: Array | None, quaternion: Array | None) -> Motion | None:
    place = np.zeros((time.size, 3)) if position is None else position
    turn = np.tile([1.0, 0, 0, 0], (time.size, 1)) if quaternion is None else quaternion
    seen = np.flatnonzero(np.isfinite(place).all(axis=1) & np.isfinite(turn).all(axis=1))
    if seen.size == 0:
        return None
    rows = seen[drawn_rows(time[seen])]
    return Motion(time[rows], place[rows], turn[rows])


def mount_motion(recording: Recording, imu: Imu, truth: Truth | None, segment: Motion) -> tuple[Motion, str]:
    """Return an IMU's pose in its segment, true or else declared, and a note for its label."""
    if truth is not None:
        sensor = truth.sensor(imu.name)
        rows = drawn_rows(truth.time)
        away = rotate_back(segment.quaternion, sensor.position[rows] - segment.position)
        return Motion(segment.time, away, multiply(conjugate(segment.quaternion), sensor.quaternion[rows])), ""
    place, note = imu.mount_position, ""
    if not place.any() and imu.mount_position_std is None and recording.tree.joints:
        place, note = np.array(recording.tree.sites[imu.name].position), " (place not declared)"
    return Motion(segment.time[:1], place[None], imu.mount_quaternion[None]), note


def log_motion(rec: rr.RecordingStream, path: str, motion: Motion) -> None:
    """Log a frame's pose, once if it stands still."""
    xyzw = np.roll(motion.quaternion, -1, axis=-1)
    if motion.still:
        rec.log(path, rr.Transform3D(translation=motion.position[0], quaternion=xyzw[0]), static=True)
    else:
        columns = rr.Transform3D.columns(translation=motion.position, quaternion=xyzw)
        rec.send_columns(path, indexes=[time_column(motion.time)], columns=columns)


def log_scene(
    rec: rr.RecordingStream,
    recording: Recording,
    truth: Truth | None,
    estimate: Estimate | None,
    reference: Reference | None,
    true_axes: Array | None,
    judge: str,
) -> Scene:
    """Log the rig in the world with its IMUs, the true joint and the estimated one as each IMU sees it.

    `true_axes` (m, 3) in sensor axes stands in where there is no truth; `judge` is the word for
    what is drawn as true.
    """
    rec.log("world", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    motions, source = segment_motions(recording, truth, reference)
    reach = dict.fromkeys(motions, SHORTEST)
    for name, motion in motions.items():
        log_motion(rec, f"world/{name}", motion)
    first_mount = np.zeros(3)
    for i, imu in enumerate(recording.imus):
        segment = recording.carrier(imu.name)
        if segment not in motions:
            continue
        mount, note = mount_motion(recording, imu, truth, motions[segment])
        first_mount = mount.position[0] if i == 0 else first_mount
        path = f"world/{segment}/{imu.name}"
        log_motion(rec, path, mount)
        site = recording.tree.sites.get(imu.name)
        _log_case(rec, path, site.case if site and site.case else FLAT_CASE, imu.name + note)
        reach[segment] = max(reach[segment], float(np.linalg.norm(mount.position[0])) + 0.06)
        centre = rotate_back(mount.quaternion[0], -mount.position[0])
        for arrow in joint_arrows(i, imu.name, centre, truth, estimate, true_axes, judge):
            log_arrow(rec, f"{path}/{arrow.quantity}_{judge if arrow.kind == 'true' else arrow.kind}", arrow)
    for name in motions:
        _log_segment(rec, recording.tree, name, reach[name])
    longest = max(reach.values(), default=SHORTEST)
    first = recording.tree.names[0] if recording.tree.segments else "segment1"
    return _log_frame(rec, recording.tree, source, motions.get(first, STILL), longest, first_mount)


def log_ghost(
    rec: rr.RecordingStream,
    path: str,
    tree: Tree,
    segments: Mapping[str, Motion],
    sensors: Mapping[str, Motion],
    colour: tuple[int, int, int],
) -> None:
    """Log a rig as wires of one colour, to be seen beside another.

    Args:
        rec: where it goes.
        path: of the ghost, below the world.
        tree: the rig.
        segments: their poses in the world, by name.
        sensors: the IMUs' poses in the world, by name.
        colour: red, green, blue, 0 to 255.
    """
    reach = dict.fromkeys(segments, SHORTEST)
    for name, sensor in sensors.items():
        site = tree.sites[name]
        if (carrier := tree.carriers[name]) in segments:
            away = np.linalg.norm(sensor.position[0] - segments[carrier].position[0])
            reach[carrier] = max(reach[carrier], float(away) + 0.06)
        log_motion(rec, f"{path}/{name}", sensor)
        case = rr.Boxes3D(
            sizes=[site.case or FLAT_CASE], colors=[colour], fill_mode=FillMode.TransparentFillMajorWireframe
        )
        rec.log(f"{path}/{name}/case", case, static=True)
    for name, motion in segments.items():
        log_motion(rec, f"{path}/{name}", motion)
        _log_limb(rec, f"{path}/{name}/body", tree, name, reach[name], colour, FillMode.TransparentFillMajorWireframe)


def _log_frame(rec: rr.RecordingStream, tree: Tree, source: str, base: Motion, longest: float, mount: Array) -> Scene:
    """Log a frame that travels with a joint that travels far, and return what a camera must know."""
    hangs = tree.ball is not None
    facing = rotate(base.quaternion, mount * [1, 1, 0] if hangs else [0.0, 1.0, 0.0]).mean(axis=0)
    middle = np.array([0.0, 0.0, -longest / 2]) if hangs else np.zeros(3)
    half = longest / 2 + 0.06 if hangs else max(longest, 0.23)  # m, an axis arrow included
    if np.ptp(base.position, axis=0).max() < TRAVEL:
        return Scene(source, "/world", middle + base.position.mean(axis=0), facing, half)
    rec.log("world/follow", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    upright = np.tile([1.0, 0, 0, 0], (base.time.size, 1))
    log_motion(rec, "world/follow", Motion(base.time, base.position, upright))
    return Scene(source, "/world/follow", middle, facing, half)


def _log_case(rec: rr.RecordingStream, path: str, size: tuple[float, float, float], label: str) -> None:
    case = rr.Boxes3D(sizes=[size], colors=[(228, 228, 236)], fill_mode="solid", labels=[label], show_labels=True)
    rec.log(f"{path}/case", case, static=True)
    rec.log(f"{path}/axes", rr.Arrows3D(vectors=np.eye(3) * 0.06, radii=0.003, colors=XYZ), static=True)


def _log_segment(rec: rr.RecordingStream, tree: Tree, name: str, reach: float) -> None:
    path = f"world/{name}/body"
    _log_limb(rec, path, tree, name, reach, SEGMENT_COLOURS.get(name, (150, 150, 150)), FillMode.Solid)
    if (tree.hinge or tree.ball) and name == tree.names[0]:
        rec.log(f"{path}/joint", _joint_shape(tree), static=True)


def _log_limb(
    rec: rr.RecordingStream,
    path: str,
    tree: Tree,
    name: str,
    reach: float,
    colour: tuple[int, int, int],
    fill: FillMode,
) -> None:
    """Log a segment's shape: a capsule from its joint to its IMU, or a box where nothing says where it goes."""
    along = {segment.name: segment.along for segment in tree.segments}.get(name)
    if along is None:
        rec.log(path, rr.Boxes3D(sizes=[(0.1, 0.1, 0.04)], colors=[colour]), static=True)
        return
    x, y, z = along
    half_way = np.array([-y, x, 0.0, 1.0 + z]) if z > -1 else np.array([1.0, 0, 0, 0])  # xyzw: turns +z to there
    capsule = rr.Capsules3D(
        lengths=[reach - 0.02],
        radii=[RADII[tree.hinge is not None]],
        translations=[(0.02 * x, 0.02 * y, 0.02 * z)],
        quaternions=[half_way / np.linalg.norm(half_way)],
        colors=[colour],
        fill_mode=fill,
    )
    rec.log(path, capsule, static=True)


def _joint_shape(tree: Tree) -> rr.Cylinders3D | rr.Ellipsoids3D:
    if tree.hinge is not None:
        upright = [[np.sqrt(0.5), 0, 0, np.sqrt(0.5)]]  # xyzw: the cylinder's z along the hinge axis y
        return rr.Cylinders3D(lengths=[0.06], radii=[0.02], quaternions=upright, colors=[JOINT], fill_mode="solid")
    return rr.Ellipsoids3D(radii=[0.05], colors=[JOINT], fill_mode="solid")
