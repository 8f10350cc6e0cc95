"""Garcia de Villa et al., ArVE_d: the synthetic experiments, figures 4 to 9, table I and their claims."""

from imubench.reproduce.arve import results
from imubench.reproduce.arve.measures import MEASURES
from imubench.reproduce.arve.published import CLAIMS
from imubench.reproduce.arve.settings import settings
from imubench.reproduce.arve.story import tell
from imubench.reproduce.paper import Paper

PAPER = Paper(
    name="arve",
    summary=f"the joint centre from one IMU: figures 4 to 9, table I, {len(CLAIMS)} claims",
    citation="S. Garcia de Villa, A. Jimenez Martin, J. J. Garcia Dominguez, Novel IMU-based Adaptive Estimator of the "
    "Center of Rotation of Joints for Movement Analysis",
    claims=CLAIMS,
    measures=MEASURES,
    settings=settings,
    parts=results.parts,
    gather=results.gather,
    tell=tell,
    method="arve-d",
    trials=results.trials,
)
