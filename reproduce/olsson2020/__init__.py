"""Olsson, Kok, Seel and Halvorsen, Sensors 20 (2020) 3534, in every figure, table and claim."""

from imubench.reproduce.olsson2020 import data, results
from imubench.reproduce.olsson2020.measures import MEASURES
from imubench.reproduce.olsson2020.published import CLAIMS
from imubench.reproduce.olsson2020.settings import settings
from imubench.reproduce.olsson2020.story import tell
from imubench.reproduce.paper import Paper

PAPER = Paper(
    name="olsson2020",
    summary=f"the plug-and-play hinge axis: figures 2 and 4 to 8, table 1, {len(CLAIMS)} claims",
    citation="F. Olsson, M. Kok, T. Seel, K. Halvorsen, Robust Plug-and-Play Joint Axis Estimation Using Inertial "
    "Sensors, Sensors 20 (2020) 3534",
    claims=CLAIMS,
    measures=MEASURES,
    settings=settings,
    parts=results.parts,
    gather=results.gather,
    tell=tell,
    method="olsson2020",
    trials=data.trials,
)
