"""Write docs/effects.md anew: every effect's law, place and parameters, and where it plays."""

from pathlib import Path

from imubench.effect_table import page

if __name__ == "__main__":
    (Path(__file__).resolve().parent.parent / "docs" / "effects.md").write_text(page(), encoding="utf-8")
