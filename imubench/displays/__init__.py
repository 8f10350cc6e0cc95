"""How recordings, truths, estimates, scores and diagnoses show themselves: in a line, a table, a plot, a notebook."""

from imubench.displays.displayed import Displayed, Summarised

__all__ = ["Displayed", "Summarised"]
