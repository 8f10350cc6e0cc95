"""Thresholds of the problem and of its solver."""

from dataclasses import dataclass

import numpy as np

from imubench.setting import setting


@dataclass(frozen=True)
class SolverConfig:
    """Levenberg-Marquardt."""

    least_gain: float = setting(1e-4, "of the cost per measured number", "a smaller gain ends the search", "numerics")
    steps: int = setting(40, "steps", "at most", "time")
    refit_steps: int = setting(
        6,
        "steps",
        "of a refit, which begins near where it ends: with a hypothesis more or less, after a pull, or with a law's "
        "numbers held",
        "time",
    )
    few_steps: int = setting(
        3, "steps", "after every change of the noise, or of a fit that only has to show something", "time"
    )
    foretold: float = setting(
        0.25, "of the least gain", "a step that gained what it promised but for so much was the last", "numerics"
    )
    most_damping: float = setting(1e3, "of the diagonal", "beyond, the fit has ended", "numerics")
    fine_gain: float = setting(
        1e-6, "of the cost per measured number", "of a fit that numbers are read off, or a law's damping", "numerics"
    )
    eased: float = setting(
        3.0, "times", "by what a whole step lowers the damping and a shortened one raises it", "numerics"
    )
    lengths: tuple[float, ...] = setting(
        (1.0, 0.5, 0.2, 0.05),
        "of a Gauss-Newton step",
        "tried before it is damped; the splines follow all but the shortest where it leads astray",
        "numerics",
    )


SOLVER = SolverConfig()


@dataclass(frozen=True)
class AlgebraConfig:
    """Sizes and rounding of the linear algebra."""

    columns: int = setting(64, "columns", "solved at once: as many as a block has numbers", "time")
    chunk_numbers: int = setting(
        900_000, "numbers", "of products of rows that are formed at once: what stays in the cache", "time"
    )
    piece_samples: int = setting(1024, "samples", "whose Jacobian is held at once", "time")
    knots_per_block: int = setting(
        8, "knots", "more than a spline's support, so that a row touches two blocks at most", "numerics"
    )
    ridge: float = setting(
        1e-14,
        "relative",
        "what rounding may take from a diagonal: no less is damped; 1e-12 held the heading, and a mount with it. A fit "
        "that numbers are read off begins so: what moves together by far does so from the first step",
        "numerics",
    )
    difference: float = setting(
        1e-4,
        "of a prior's or a number's std, or rad and rad/s",
        "of derivatives by differences, linear over it to 1e-8; a direction that shows less than so much shows nothing",
        "numerics",
    )
    damped: float = setting(
        1e-8,
        "of the diagonal",
        "what next to nothing holds, beyond a sensor's last sample, stays where it is",
        "numerics",
    )
    spline_solves: int = setting(
        2, "solves", "of a law, or of the own splines of effects: the second where the first has led", "numerics"
    )
    moved: float = setting(
        0.03, "of a plausible size", "by which splines move before a second solve is made", "numerics"
    )
    knots_beside: int = setting(
        5000, "knots", "of a fit that has another beside it, at most: of 25 s at 200 Hz", "time"
    )
    most_log_step: float = setting(30.0, "of a logarithm", "a step that leads beyond is taken back anyhow", "numerics")
    held: float = setting(1e-6, "of a prior's std", "how far a parameter moves that is fixed", "numerics")

    @property
    def ridges(self) -> tuple[float, ...]:
        """Of a block's diagonal: none, and what rounding of many such may take from it, where it did."""
        return (0.0, 10 * self.ridge, 100 * self.ridge)

    @property
    def half_digits(self) -> float:
        """Relative, half the digits of a float: of values and weights, less than this is rounding."""
        return float(np.sqrt(np.finfo(float).eps))


ALGEBRA = AlgebraConfig()


@dataclass(frozen=True)
class StartConfig:
    """Where a fit begins."""

    linear_offset_s: float = setting(
        0.004, "s", "clock offset that a linear score could not judge any more", "numerics"
    )
    linear_pose_offset_s: float = setting(
        0.001, "s", "the same of a pose beside the only IMU: sooner its own noise would become the motion", "numerics"
    )
    least_correlation: float = setting(
        0.5, "1", "of two signals, under which they tell nothing of the clocks", "judgement"
    )
    most_offset_s: float = setting(0.25, "s", "the largest clock offset that is looked for", "judgement")
    rate_window_s: float = setting(
        0.02, "s", "standard deviation of the window over which an encoder's rate is taken", "numerics"
    )
    most_knots_per_s: float = setting(
        128.0, "1/s", "no rig moves faster than that shows, and time grows with their number", "time"
    )
    levelling_s: float = setting(
        3.0, "s", "over which the mean specific force is taken for up, as VQF's time constant is", "judgement"
    )
    edge_s: float = setting(
        0.06, "s", "of spline beyond the first and the last sample, besides the largest clock offset", "numerics"
    )
    subset_margin_s: float = setting(0.1, "s", "of spline beyond the first and the last sample of a part", "numerics")
    subset_hop_s: float = setting(1.0, "s", "between the windows that are compared", "time")
    lawful_state_roughness: float = setting(
        1e9, "of a state's size/s^4/sqrt(Hz)", "a law alone says how it moves", "numerics"
    )


START = StartConfig()


@dataclass(frozen=True)
class MotionPriorConfig:
    """What a motion, a mount and an encoder are held by."""

    unknown_position_m: float = setting(
        0.3, "m", "prior std of a mount that nobody declared, and of a sensor's lever arm", "judgement"
    )
    unknown_rotation_rad: float = setting(1.0, "rad", "prior std of a mount that nobody declared", "judgement")
    white_derivative: int = setting(
        4,
        "order",
        "of the derivative that is taken for white: accelerations fall with the square of the frequency",
        "physics",
    )
    norm_std: float = setting(
        0.1,
        "1",
        "how closely an attitude's quaternion keeps its norm: only holds a direction without meaning",
        "numerics",
    )
    centre_m_s: float = setting(
        1.0, "m/s", "how fast a joint centre that nobody measured moves, a second later being another draw", "physics"
    )
    centre_drift_m_s2: float = setting(
        0.05, "m/s^2", "how closely its velocity follows its specific force; over a second 0.005 m/s", "judgement"
    )
    heading_half_rad: float = setting(
        0.03, "half rad", "about the vertical from the first attitude of the start: nothing may see it", "numerics"
    )
    encoder_zero_rad: float = setting(
        0.01, "rad", "how well anybody sets a zero to a base, and levels that base", "judgement"
    )
    encoder_wave_rad: float = setting(
        1e-3, "rad", "error once a turn of a disc that sits off its axle by a few hundredths of a millimetre", "physics"
    )
    encoder_waves: int = setting(
        6, "waves", "of the turn, the k-th held to 1 / k^2: what 12 take more of one swing the next has not", "trials"
    )


MOTION_PRIOR = MotionPriorConfig()


@dataclass(frozen=True)
class SwingConfig:
    """A free swing and its equation."""

    still_rad_s: float = setting(
        0.05, "rad/s", "mean or RMS rate under which a segment or a sensor is at rest", "physics"
    )
    rest_s: float = setting(0.3, "s", "over which the mean rate is taken for that", "judgement")
    jump_knots: float = setting(
        2.0,
        "knot intervals",
        "within which no spline follows a torque that jumps: let go, turned round, held",
        "numerics",
    )
    hard_factor: float = setting(
        1.5, "times gravity's acceleration", "quicker, the segment is turned round by a stop", "physics"
    )
    equation_std: float = setting(
        0.01, "of the weight's torque", "how closely the equation holds, before it is estimated", "judgement"
    )
    unheld: float = setting(
        0.7, "of 1 % of the weight's torque", "from which on a swing does not go as its equation says", "trials"
    )


SWING = SwingConfig()
