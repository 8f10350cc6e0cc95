"""A rig as a tree, read from its MJCF: segments, the joints that hold them, and the IMUs on them.

A segment is a body that stands in the world or that a joint moves. An IMU is a site that a gyro or an accelerometer
reads. A body that has the name of an IMU is its mount and no segment; a body without a joint belongs to the segment
that it is fixed to. Who needs to know what a rig can do asks its tree, not its name.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

from imubench.models import RIG_FILES, is_rig, mjcf

HINGE, BALL, SLIDE, FREE = "hinge", "ball", "slide", "free"
"""The kinds of joint, as MuJoCo calls them."""

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]


@dataclass(frozen=True)
class Joint:
    """What holds a segment to its parent, or to the world."""

    name: str
    kind: str  # HINGE, BALL, SLIDE or FREE
    axis: Vector  # of a hinge or a slide, in axes of the segment that it moves


@dataclass(frozen=True)
class ImuSite:
    """An IMU as its file has it."""

    name: str
    position: Vector  # m, segment frame
    quaternion: Quaternion  # sensor -> segment
    case: Vector | None  # m, along the sensor's axes; None: it has no picture


@dataclass(frozen=True)
class TreeSegment:
    """A rigid part of a rig."""

    name: str
    parent: str | None  # the segment that it hangs on; None: the world
    joints: tuple[Joint, ...]
    imus: tuple[ImuSite, ...]
    along: Vector | None  # unit, own axes, from the joint to its far end; None: it is no capsule

    @property
    def floats(self) -> bool:
        """Whether it can go wherever it is carried."""
        return any(joint.kind == FREE for joint in self.joints)


@dataclass(frozen=True)
class Tree:
    """The segments of a rig, a parent before what hangs on it; none of a rig that nobody has read."""

    segments: tuple[TreeSegment, ...]

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The segments' names."""
        return tuple(segment.name for segment in self.segments)

    @cached_property
    def imus(self) -> tuple[str, ...]:
        """The IMUs' names, in the order of their segments."""
        return tuple(imu.name for segment in self.segments for imu in segment.imus)

    @cached_property
    def carriers(self) -> dict[str, str]:
        """By IMU: the segment that carries it."""
        return {imu.name: segment.name for segment in self.segments for imu in segment.imus}

    @cached_property
    def sites(self) -> dict[str, ImuSite]:
        """The IMUs by name."""
        return {imu.name: imu for segment in self.segments for imu in segment.imus}

    @cached_property
    def joints(self) -> tuple[Joint, ...]:
        """The joints that turn about a point which they hold: all but free ones and slides."""
        return tuple(j for segment in self.segments for j in segment.joints if j.kind in (HINGE, BALL))

    @property
    def joint(self) -> Joint | None:
        """The joint of the last segment, at which effects of the place "joint" act; None: nothing holds it."""
        return self.joints[-1] if self.joints else None

    @property
    def kind(self) -> str:
        """The kind of that joint: HINGE or BALL; FREE where nothing holds the segment, "" of a rig nobody has read."""
        if self.joint is not None:
            return self.joint.kind
        return FREE if self.segments else ""

    @property
    def hinge(self) -> Joint | None:
        """That joint, if it is a hinge."""
        return self.joint if self.kind == HINGE else None

    @property
    def ball(self) -> Joint | None:
        """That joint, if it is a ball joint."""
        return self.joint if self.kind == BALL else None

    @property
    def pair(self) -> tuple[str, str] | None:
        """The IMUs on both sides of that joint: on what holds the last segment, and on the last one."""
        if not self.segments or self.last.parent is None:
            return None
        holding = next(segment for segment in self.segments if segment.name == self.last.parent)
        return (holding.imus[0].name, self.last.imus[0].name) if holding.imus and self.last.imus else None

    @property
    def base(self) -> Joint | None:
        """The joint that holds the first segment to the world."""
        return self.segments[0].joints[0] if self.segments and self.segments[0].joints else None

    @property
    def floats(self) -> bool:
        """Whether the first segment can be carried anywhere: its origin moves, and nothing says where it is."""
        return bool(self.segments) and self.segments[0].floats

    @property
    def loose(self) -> bool:
        """Whether no segment is held by a joint: a free body."""
        return self.kind == FREE

    @property
    def clamps(self) -> bool:
        """Whether the first segment can be bolted to the world and another one still moves."""
        return self.floats and bool(self.joints)

    @property
    def last(self) -> TreeSegment:
        """The segment at the end of the tree, which swings."""
        return self.segments[-1]


UNREAD = Tree(())
"""The tree of a rig of its owner's own: its joints and segments are not known yet."""


def tree_of(spec: Any) -> Tree:
    """Return the tree of a `mujoco.MjSpec`.

    Args:
        spec: the model, not compiled.

    Returns:
        Its segments with their joints, IMUs and direction.
    """
    import mujoco

    model = spec.copy().compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)  # where everything is while the joints are at zero
    reads = (mujoco.mjtSensor.mjSENS_GYRO, mujoco.mjtSensor.mjSENS_ACCELEROMETER)
    sites = {sensor.objname for sensor in spec.sensors if sensor.type in reads}
    mounts = {body.name for body in spec.bodies if body.name in sites}
    found: dict[str, TreeSegment] = {}
    for body in spec.bodies:
        if body.name == "world" or body.name in mounts or not (body.joints or body.parent.name == "world"):
            continue
        parts = _parts(body, mounts)
        parent = body.parent
        while parent.name != "world" and parent.name not in found:
            parent = parent.parent
        found[body.name] = TreeSegment(
            body.name,
            None if parent.name == "world" else parent.name,
            tuple(_joint(joint) for joint in body.joints),
            tuple(_imu(site, part, body, data) for part in parts for site in part.sites if site.name in sites),
            _along(body),
        )
    return Tree(tuple(found.values()))


def _parts(body: Any, mounts: set[str]) -> list[Any]:
    """Return a segment's body, and what is fixed to it or mounted on it."""
    fixed = [child for child in body.bodies if not child.joints or child.name in mounts]
    return [body, *(part for child in fixed for part in _parts(child, mounts))]


def _joint(joint: Any) -> Joint:
    kind = joint.type.name.removeprefix("mjJNT_").lower()
    return Joint(joint.name, kind, _vector(joint.axis))


def _imu(site: Any, part: Any, segment: Any, data: Any) -> ImuSite:
    """Return the IMU at a site of a segment or of a part of it; a mount's box is its case."""
    import mujoco
    import numpy as np

    boxes = [geom for geom in part.geoms if geom.type == mujoco.mjtGeom.mjGEOM_BOX]
    case = _vector(2 * boxes[0].size) if part.name == site.name and boxes else None
    frame = data.body(segment.name)
    axes = frame.xmat.reshape(3, 3).T
    at = axes @ (data.site(site.name).xpos - frame.xpos)
    turn = np.zeros(4)
    mujoco.mju_mat2Quat(turn, (axes @ data.site(site.name).xmat.reshape(3, 3)).ravel())
    w, x, y, z = (float(v) for v in turn)
    return ImuSite(site.name, _vector(at), (w, x, y, z), case)


def _along(body: Any) -> Vector | None:
    """Return the direction (3,) of a segment's capsule, from the end near its origin to the far one."""
    import numpy as np

    for geom in body.geoms:
        ends = np.asarray(geom.fromto).reshape(2, 3)
        if np.isfinite(ends).all():
            far = max(ends, key=np.linalg.norm)
            return _vector(far / np.linalg.norm(far))
    return None


def _vector(values: Any) -> Vector:
    x, y, z = (float(v) for v in values)
    return x, y, z


def rig_spec(rig: str) -> Any:
    """Return the `mujoco.MjSpec` of a rig's file, to be changed at will."""
    import mujoco

    return mujoco.MjSpec.from_string(mjcf(rig))


def rig_tree(rig: str) -> Tree:
    """Return the tree of one of our rigs or of a package's; `UNREAD` of any other."""
    if rig in RIG_FILES:
        return _tree(rig, None)
    return _tree(rig, mjcf(rig)) if is_rig(rig) else UNREAD


@lru_cache
def _tree(rig: str, text: str | None) -> Tree:
    """Return a rig's tree; `text` is the MJCF of a package's, which may be installed anew."""
    import mujoco

    return tree_of(rig_spec(rig) if text is None else mujoco.MjSpec.from_string(text))


__all__ = [
    "BALL",
    "FREE",
    "HINGE",
    "SLIDE",
    "UNREAD",
    "ImuSite",
    "Joint",
    "Tree",
    "TreeSegment",
    "rig_spec",
    "rig_tree",
    "tree_of",
]
