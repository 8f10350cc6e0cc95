"""Samples of a fit that are averaged from several of the recording's: by how much less they have of white noise.

Noise levels, misfits and limits of a diagnosis are those of the recording's samples. Let white noise of std s in these
have q s in a fit's. What is there beside it, slower than both rates, has the same power in both: (p - 1) q^2 s^2 where
a fit's samples have p times the power of their noise. So the recording's have

    1 + (p - 1) q^2

times theirs. Over the density of the white noise it is the same in both, that of samples q^2 times as far apart as the
fit's.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Averaging:
    """Noise of a fit's samples beside that of the recording's, by triple ("imu1.gyro")."""

    shares: Mapping[str, float] = field(default_factory=dict)  # std over that of the recording's; none: 1
    zero: float | None = None  # s, the recording's first stamp; None: the fit's

    def share(self, name: str) -> float:
        """Return the std of white noise in a fit's sample over that in one of the recording's."""
        return self.shares.get(name, 1.0)

    def in_fit(self, noise: Mapping[str, float]) -> dict[str, float]:
        """Return the noise std of a fit's samples of those of the recording's, by triple."""
        return {name: std * self.share(name) for name, std in noise.items()}

    def power(self, name: str, power: float) -> float:
        """Return the power over the noise's in the recording's samples, of that in a fit's."""
        return 1 + (power - 1) * self.share(name) ** 2

    def power_in_fit(self, name: str, power: float) -> float:
        """Return the power over the noise's in a fit's samples, of that in the recording's."""
        return 1 + (power - 1) / self.share(name) ** 2

    def step(self, name: str, step: float) -> float:
        """Return how many s apart the recording's samples are, of a fit's every `step` s."""
        return step * self.share(name) ** 2


AS_RECORDED = Averaging()
"""Of a fit that sees the recording's own samples."""

__all__ = ["AS_RECORDED", "Averaging"]
