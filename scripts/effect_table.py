"""Write docs/effects.md: which effect plays on which rig, by which door."""

from pathlib import Path

from imubench.effect_table import page

if __name__ == "__main__":
    (Path(__file__).resolve().parent.parent / "docs" / "effects.md").write_text(page(), encoding="utf-8")
