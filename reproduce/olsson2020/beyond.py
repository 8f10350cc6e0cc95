"""What the paper leaves open: which imperfection makes its errors, and where plug and play stops.

Two studies in one report, without claims of their own. Seeds are part of the studies: `--seed` shifts none.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from imubench.reproduce.olsson2020 import imperfection_exhibits, imperfection_results, robustness, robustness_exhibits
from imubench.reproduce.olsson2020.imperfection_results import Imperfect
from imubench.reproduce.olsson2020.robustness import Map
from imubench.reproduce.paper import Arrays, Paper, Part, Story


@dataclass(frozen=True)
class Studies:
    """The extents of both studies, or what came out of them."""

    imperfections: imperfection_results.Extent
    maps: robustness.Extent


def settings(quick: bool, seed: int) -> Studies:
    """Return how much is computed."""
    if quick:
        return Studies(imperfection_results.QUICK, robustness.QUICK)
    return Studies(imperfection_results.FULL, robustness.FULL)


def parts(s: Studies) -> list[Part]:
    """Return the work of both studies."""
    return [*imperfection_results.parts(s.imperfections), *robustness.parts(s.maps)]


def gather(s: Studies, done: Mapping[str, Arrays]) -> tuple[Imperfect, dict[str, Map]]:
    """Return the results of both studies."""
    return imperfection_results.gather(s.imperfections, done), robustness.gather(s.maps, done)


def tell(results: tuple[Imperfect, dict[str, Map]]) -> Story:
    """Return the figures and tables of both studies."""
    imperfect, maps = results
    setting = (
        "A rigid simulated hinge with an Xsens MTw on either segment errs by hundredths of a degree, where the paper "
        "measured 1.5 deg in all four sequences. Each imperfection of a real rig is therefore added alone and swept "
        "over what is plausible. The maps show how much bias, softness and delay the whole method bears."
    )
    notes = (
        "Errors are those of final estimates: selection with N_max = 500, Algorithm 1, random starts.",
        "Motions are shortened (10 to 24 s each) to keep the run short.",
        "Plausible ranges are judgements from dimensions, clearances and data sheets.",
    )
    exhibits = (*imperfection_exhibits.exhibits(imperfect), *robustness_exhibits.exhibits(maps))
    return Story(setting, exhibits, notes)


PAPER = Paper(
    name="olsson2020-beyond",
    summary="which imperfection makes the plug-and-play paper's errors, and maps of where its method stops",
    citation="A study beside F. Olsson, M. Kok, T. Seel, K. Halvorsen, Sensors 20 (2020) 3534",
    claims=(),
    measures={},
    settings=settings,
    parts=parts,
    gather=gather,
    tell=tell,
)
