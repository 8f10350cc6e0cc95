"""A diagnosis as one HTML file that a person understands at first sight."""

from imubench.diagnosis.report.first_screen import Paths
from imubench.diagnosis.report.page import page

__all__ = ["Paths", "page"]
