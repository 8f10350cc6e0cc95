"""Write docs/glossary.md anew: `python scripts/write_glossary.py`."""

from pathlib import Path

from imubench.explain import glossary_page

TARGET = Path(__file__).resolve().parent.parent / "docs" / "glossary.md"

if __name__ == "__main__":
    TARGET.write_text(glossary_page(), encoding="utf-8")
