"""Take the picture of the report that the README shows: the top of the published campaign's, as a browser draws it."""

from __future__ import annotations

import shutil
import sys
import tempfile
from pathlib import Path

from playwright.sync_api import sync_playwright

from inertialcal.campaign.engine.run import run
from inertialcal.campaign.file.example import copy_example

HERE = Path(__file__).resolve().parent
SIZE = {"width": 1440, "height": 900}  # [px]
QUIET = ("--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking")


def main() -> int:
    """Run the example, open its report, write the picture."""
    program = shutil.which("chromium")
    if program is None:
        print("needs chromium", file=sys.stderr)
        return 2
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        run(copy_example("npsat2011", Path(folder) / "example"))
        browser = playwright.chromium.launch(executable_path=program, args=list(QUIET))
        page = browser.new_page(viewport=SIZE, color_scheme="light")
        page.goto((Path(folder) / "example/out/report.html").as_uri())
        page.screenshot(path=HERE / "images/report.png")
        browser.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
