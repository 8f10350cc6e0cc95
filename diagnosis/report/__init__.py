"""A diagnosis as one HTML file that a person understands at first sight."""

from imubench.diagnosis.report.page import page

__all__ = ["page"]
