"""Thresholds of what is done with a diagnosis."""

from dataclasses import dataclass

from imubench.setting import setting


@dataclass(frozen=True)
class ReadModelConfig:
    """What a model that is read may hold."""

    most_samples: int = setting(
        2_000_000, "samples", "of a sensor: what fits into a gigabyte while MuJoCo plays it", "time"
    )
    least_rate_hz: float = setting(0.1, "Hz", "of inertial sensors and encoders", "judgement")
    most_rate_hz: float = setting(10_000.0, "Hz", "of inertial sensors and encoders", "judgement")
    edge_s: float = setting(0.5, "s", "by which samples may go on beyond the motion's first and last row", "judgement")
    rounding_s: float = setting(1e-6, "s", "by which rounding may move an end", "numerics")

    @property
    def most_s(self) -> float:
        """In s, of a recording: as many states at the least rate that is played as samples of a sensor."""
        return self.most_samples / REPLAY.least_rate_hz


READ_MODEL = ReadModelConfig()


@dataclass(frozen=True)
class ReplayConfig:
    """A found model that is played again."""

    least_rate_hz: float = setting(
        400.0, "Hz", "what is read between samples of the simulation is interpolated by cubics", "numerics"
    )
    end_rows: int = setting(4, "rows", "of a simulation at its ends, for what is interpolated there", "numerics")
    steps_per_knot: int = setting(4, "steps", "on which the force at the joint becomes a movement", "numerics")


REPLAY = ReplayConfig()
