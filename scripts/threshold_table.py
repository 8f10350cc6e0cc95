"""Write docs/thresholds.md anew: every threshold of the diagnosis with its unit, its reason and its source."""

from pathlib import Path

from imubench.threshold_table import page

if __name__ == "__main__":
    (Path(__file__).resolve().parent.parent / "docs" / "thresholds.md").write_text(page(), encoding="utf-8")
