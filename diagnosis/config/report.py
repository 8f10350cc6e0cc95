"""Thresholds and sizes of the report."""

from dataclasses import dataclass

from imubench.setting import setting


@dataclass(frozen=True)
class ChartConfig:
    """Sizes of the figures."""

    width: int = setting(1000, "units of a viewBox", "about the pixels of a page", "convention")
    height: int = setting(200, "units of a viewBox", "of one channel", "convention")
    gap: float = setting(5.0, "usual steps", "no line is drawn across more lost samples than that", "convention")
    ticks: int = setting(5, "numbers", "along an axis", "convention")
    columns: int = setting(120, "columns", "over time: a phone has about 300 pixels for them", "convention")
    bins: int = setting(60, "rows", "over frequency", "convention")
    levels: tuple[float, ...] = setting(
        (1.5, 3.0, 6.0, 15.0, 50.0),
        "of the noise",
        "from which each darker step begins: 1.5 is beyond what noise does by chance in half a second, and "
        "six steps are as many as can be told apart",
        "statistics",
    )
    dots_per_inch: int = setting(130, "1/inch", "of the picture", "convention")


CHART = ChartConfig()


@dataclass(frozen=True)
class PageConfig:
    """What the page says."""

    excerpt_s: float = setting(
        3.0, "s", "some thirty cycles of the mounts' usual 10 Hz, each 30 pixels wide", "convention"
    )
    most: float = setting(
        0.5,
        "of a whole",
        "a difference with more of its power at less than a cycle an excerpt is shown whole; of a number of which the "
        "recording says less, what is plausible says more",
        "convention",
    )
    listed: int = setting(
        2,
        "channels or sentences",
        "of a finding, and of where simulations differ; the others stand at the map",
        "convention",
    )
    ideal_noise: float = setting(
        1e-4,
        "rad/s and m/s^2",
        "per sample, below which a profile's noise is that of no IMU on sale: the quietest MEMS gyroscope of "
        "the list has 1.7e-3 rad/s",
        "data sheet",
    )


PAGE = PageConfig()
