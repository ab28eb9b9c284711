"""Draw the pictures of the gallery anew: play the page, and keep what its commands write, in few colours."""

from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path

from PIL import Image

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parents[1] / "tests"))

from test_manual import FENCE, Session  # noqa: E402 - found by the line above

COLOURS, WIDEST = 64, 1000  # of a picture on the page


def main() -> None:
    """Play the page in an empty folder."""
    text = (HERE / "figures.md").read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        session = Session()
        for block in FENCE.finditer(text):
            session.play(block["kind"], block["body"])
        for path in sorted(Path(folder).glob("*.png")):
            picture = Image.open(path).convert("RGB")
            picture.thumbnail((WIDEST, WIDEST))
            picture.quantize(COLOURS).save(HERE / "figures" / path.name, optimize=True)
            print(f"figures/{path.name}")
        os.chdir(HERE)


if __name__ == "__main__":
    main()
