"""Take pictures of a page without a screen: `python scripts/page_screenshots.py report.html pictures/`.

Needs Chromium on the path (Debian: chromium). Written are NAME-desktop.png, NAME-phone.png and NAME-dark.png; a folder
of a diagnosis may be given instead of its report.
"""

import argparse
import shutil
import subprocess
from pathlib import Path

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")
DESKTOP, PHONE = (1280, 3000), (390, 5200)
"""Widths and heights in CSS pixels: of a laptop's window, and of a usual phone; as high as most reports are."""
PATIENCE = 120  # s a picture
DARK = ("--blink-settings=preferredColorScheme=0",)


def browser() -> str:
    """Return the browser's path; SystemExit with a line where there is none."""
    found = next((path for name in BROWSERS if (path := shutil.which(name))), None)
    if found is None:
        raise SystemExit(f"expected one of {', '.join(BROWSERS)} on the path, got none; Debian: apt install chromium")
    return found


def picture(page: Path, target: Path, size: tuple[int, int], options: tuple[str, ...] = ()) -> None:
    """Draw an HTML file into a PNG of `size` CSS pixels.

    A headless window is never narrower than 500 pixels, so a phone's page is shown in a frame of its width.
    """
    width, height = size
    shown = page.resolve()
    frame = target.with_suffix(".html")
    if width < 500:
        frame.write_text(
            f"<!doctype html><style>body{{margin:0}}iframe{{border:0;width:{width}px;height:{height}px}}</style>"
            f"<iframe src='{shown.as_uri()}'></iframe>",
            encoding="utf-8",
        )
        shown = frame.resolve()
    command = [
        browser(), "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", *options,
        f"--window-size={max(width, 500)},{height}", f"--screenshot={target.resolve()}", shown.as_uri(),
    ]  # fmt: skip
    subprocess.run(command, check=True, capture_output=True, timeout=PATIENCE)
    frame.unlink(missing_ok=True)
    if not target.is_file():
        raise SystemExit(f"{page}: expected a picture at {target}, got none")


def main() -> None:
    """Take the three pictures of the page that the command line names."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("page", type=Path, help="a report.html, or the folder that holds it")
    parser.add_argument("folder", type=Path, help="where the pictures go")
    given = parser.parse_args()
    page = given.page / "report.html" if given.page.is_dir() else given.page
    if not page.is_file():
        parser.error(f"{page}: expected an HTML file, found none")
    given.folder.mkdir(parents=True, exist_ok=True)
    for kind, size, options in (("desktop", DESKTOP, ()), ("phone", PHONE, ()), ("dark", DESKTOP, DARK)):
        target = given.folder / f"{page.stem}-{kind}.png"
        picture(page, target, size, options)
        print(target)


if __name__ == "__main__":
    main()
