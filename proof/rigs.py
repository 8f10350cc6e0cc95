"""The rigs of the generator: what each one is made of. Everything else asks this, not a rig's name."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Shape:
    """Segments and joint of a rig; axes are those of its segments, by number."""

    imus: int  # one on each segment
    motion: int  # unknown functions of time that it has, moved by hand on a free base
    along: int  # the axis along a limb
    turns_about: int  # the axis about which no recording without a pose or an encoder shows a sensor's turn
    hinge: bool = False
    ball: bool = False
    sides: tuple[int, ...] = ()  # of the joint, on which each IMU sits, along the limb; (): anywhere near the origin
    reach: tuple[float, float] = (0.0, 0.0)  # m from the joint
    effects: tuple[str, ...] = ()  # at its joint, moved by hand

    @property
    def jointed(self) -> bool:
        """Whether a joint holds it."""
        return self.hinge or self.ball


SHAPES = {
    "hinge": Shape(
        imus=2,
        motion=7,
        along=0,
        turns_about=1,
        hinge=True,
        sides=(-1, 1),
        reach=(0.06, 0.25),
        effects=("joint_play", "axis_coupling", "moving_centre"),
    ),
    "pendulum": Shape(
        imus=1, motion=3, along=2, turns_about=2, ball=True, sides=(-1,), reach=(0.1, 0.35), effects=("moving_pivot",)
    ),
    "free": Shape(imus=1, motion=6, along=2, turns_about=2),
}
