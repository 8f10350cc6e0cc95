"""Runs as Rerun files."""

from imubench.log.run import log_run

__all__ = ["log_run"]
