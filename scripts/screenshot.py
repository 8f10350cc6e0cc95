"""Take a picture of a .rrd file without a screen: `python scripts/screenshot.py run.rrd run.png --time 2.5`.

Needs a Vulkan driver; Mesa's software one will do (Debian: mesa-vulkan-drivers).
"""

import argparse
import socket
import sys
import time
from pathlib import Path

from rerun.experimental import ViewerClient

PATIENCE = 30.0  # s to load a file


def free_port() -> int:
    """Return a TCP port that nothing listens on."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def screenshot(source: Path, target: Path, at: float, settle: float) -> None:
    """Draw `source` at `at` s of its time into the PNG `target`; give the layout `settle` s to come to rest."""
    rerun = Path(sys.executable).with_name("rerun")
    viewer = ViewerClient.spawn(headless=True, port=free_port(), executable_path=str(rerun) if rerun.exists() else None)
    try:
        viewer.open(str(source.resolve()))
        until = time.monotonic() + PATIENCE
        while viewer.get_state().loading:
            if time.monotonic() > until:
                raise TimeoutError(f"{source}: still loading after {PATIENCE:g} s")
            time.sleep(0.2)
        viewer.set_time("sim_time", duration=at)
        time.sleep(settle)
        viewer.save_screenshot(str(target.resolve()))
        for view in viewer.get_state().views:
            for report in view.reports:
                print(f"{view.name}: {report.severity}: {report.summary}", file=sys.stderr)
    finally:
        viewer.quit()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("source", type=Path, help="a .rrd file")
    parser.add_argument("target", type=Path, help="the .png to write")
    parser.add_argument("--time", type=float, default=2.0, help="s on the timeline sim_time")
    parser.add_argument("--settle", type=float, default=2.0, help="s to wait before the picture")
    given = parser.parse_args()
    if not given.source.is_file():
        parser.error(f"{given.source}: expected a .rrd file, found none")
    screenshot(given.source, given.target, given.time, given.settle)
