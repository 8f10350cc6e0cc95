"""What the report tells a stranger about the run."""

from imubench.reproduce.olsson2020 import figure2, figure4, figure5, figure6, figure7, figure8, sessions, table1
from imubench.reproduce.olsson2020.results import Results
from imubench.reproduce.olsson2020.settings import DRAWS
from imubench.reproduce.paper import Story

EXHIBITS = (figure2, figure4, figure5, figure6, figure7, figure8, sessions, table1)


def tell(r: Results) -> Story:
    """Return the setting, the figures and the table in the paper's order, and the readings taken."""
    s = r.settings
    setting = (
        "The paper finds the axis of a hinge in the coordinates of two inertial sensors, one on either segment, from "
        "whatever motion there was, and says when its answer can be trusted. Its data, 14 motions of a printed "
        "hinge held "
        "in hands, are not published. Here the same motions are simulated: a rigid hinge, a sensor with the "
        "noise and the "
        f"biases of an Xsens MTw on either segment, {r.duration('sequence1'):.0f} s at 50 Hz, and the gyroscopes' bias "
        "removed as in the paper. The true axis is known exactly. The method is the paper's, Algorithms 1 to "
        "4, with the "
        f"paper's parameters; random numbers follow from seed {s.seed}. One session is one draw of the motions "
        "and of the "
        "sensors, as the paper's recording is one."
    )
    lengths = (
        "The motions last 65 (1), 30 (2), 70 (8), 60 (9) and 47.5 s (all others): the paper gives no lengths, "
        "these follow "
        "from four remarks in its text, so that its times can be compared."
    )
    notes = (
        lengths,
        "Scenarios are called sequences here.",
        f"The paper gives no V_tol (here 1e-10 of the cost), no number of Monte Carlo draws (here {DRAWS}) and "
        "does not "
        "say what Algorithm 3 chooses from as samples arrive (here: from what it kept, and the new ones).",
        "Equation 25 prints the same accelerometer twice; equation 27 has the right pair, and so has the code.",
        "The text gives 81 % (section 8.3) and 88 % (section 9.3) for the same rate; 81 is taken.",
        "Runs on the same samples whose first descents end in the same minimum (to 1e-6 rad) share the second descent.",
        "Runs with added biases end where Algorithm 4 accepts. All others go on to the end of the sequence.",
    )
    return Story(setting, tuple(module.exhibit(r) for module in EXHIBITS), notes)
