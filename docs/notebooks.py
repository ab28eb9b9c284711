"""Execute the notebooks of the gallery, and write them as pages: ``python docs/notebooks.py``; ``--check`` compares.

A notebook is made from the list of its cells here, so that its outputs are never older than its code. Its kernel runs
in an empty folder; no path of a machine, no time and no count of a run is kept.
"""

from __future__ import annotations

import argparse
import base64
import json
import os
import re
import sys
import tempfile
from pathlib import Path
from typing import Any

import nbformat
from nbclient import NotebookClient

GALLERY = Path(__file__).parent / "gallery"
FIRST_LINES, LAST_LINES = 12, 30  # of a long output on the page
TEXTS = ("text/plain", "text/html")
# Pictures differ between versions of libraries; the checksum of a model tells the last bits of its numbers
NOT_COMPARED = re.compile(r"<svg.*?</svg>|(?<=compensated by model )[0-9a-f]{12}", re.DOTALL)
FIRST = [
    (
        "markdown",
        """# A first calibration

From the readings of a rate table to a model, its verdict, and compensated readings. The data are those of a published
suite of three rate gyroscopes, which the package brings: `inertialcal demo npsat2011` copies them into a folder.""",
    ),
    (
        "code",
        """%matplotlib inline
import subprocess
import sys

import numpy as np

import inertialcal as ic

copied = subprocess.run([sys.executable, "-m", "inertialcal", "demo", "npsat2011", "--quiet"], check=True)""",
    ),
    (
        "markdown",
        "## The readings\n\nA row is a dwell: the table turns at a known rate, and the mean reading is noted.",
    ),
    ("code", 'ic.read_table("inertialcal-demo/table10_x.csv")'),
    (
        "markdown",
        """## One test

Scale factor, bias and asymmetry of the x axis, each with its standard uncertainty and 95 % interval. What the table
cannot give is not estimated, and the reason is said.""",
    ),
    (
        "code",
        """found = ic.rate_table(
    "inertialcal-demo/table10_x.csv",
    reading="reading_minus_ref_dps",
    axis="x",
    zero_reference=True,
    input_range="5 deg/s",
    scale_factor="0.5 V/(deg/s)",
)
found""",
    ),
    ("code", "ic.plot(found);"),
    (
        "markdown",
        """## The campaign

`campaign.toml` names all tests, and the requirements. A run judges each of them: PASS, FAIL, or INCONCLUSIVE where the
data cannot tell.""",
    ),
    ("code", 'outcome = ic.run("inertialcal-demo")\noutcome'),
    ("markdown", "## The model\n\nThe tests that are for the fit become one model of the sensor."),
    ("code", 'model = ic.load_model("inertialcal-demo")\nmodel'),
    ("code", "ic.plot(model);"),
    (
        "markdown",
        """## Compensated readings

The model undoes what the sensor does: readings, and the rates that they stand for. An axis is a column.""",
    ),
    (
        "code",
        """readings = np.array([[1.0, 0.0, 0.0], [0.0, 3.0, -3.0]])  # deg/s
rates = ic.compensate(model, readings, sample_rate=1.0, units=dict.fromkeys("xyz", "deg/s"))
rates""",
    ),
]
NOISE = [
    (
        "markdown",
        """# Noise of a gyro, from a record to a filter

A sensor at rest says how far its readings can be averaged, and which numbers a filter needs. The record is made
here, so that the truth is known: white noise, and a bias that wanders.""",
    ),
    (
        "code",
        """%matplotlib inline
import numpy as np

import inertialcal as ic
from inertialcal.procedures.static_noise.filters import filter_block

draw = np.random.default_rng(1)
rate, n = 10.0, 200_000  # Hz, samples: five and a half hours
white, walk = 0.003, 1e-5  # deg/s/sqrt(Hz), deg/s/sqrt(s)
still = white * np.sqrt(rate) * draw.standard_normal(n)
still += np.cumsum(walk / np.sqrt(rate) * draw.standard_normal(n))""",
    ),
    (
        "markdown",
        """## The terms

Each term that the record shows has an uncertainty and a 95 % interval. A term that it does not show has an
upper limit or a reason, never a number read off a slope.""",
    ),
    ("code", 'found = ic.allan(still, sample_rate=rate, units="deg/s")\nfound'),
    ("code", "ic.plot(found);"),
    (
        "markdown",
        """## Against the truth

Angle random walk is white noise in the units of data sheets: deg/s/sqrt(Hz) times 60 is deg/sqrt(h). The walk
of the bias is rate random walk, in deg/s/sqrt(s).""",
    ),
    (
        "code",
        """truth = {"angle_random_walk": 60 * white, "rate_random_walk": walk * 60 * 3600}
for row in found.rows:
    if row.quantity in truth and row.method == "result":
        low, high = row.interval.lo, row.interval.hi
        where = "inside" if low <= truth[row.quantity] <= high else "outside"
        print(f"{row.quantity}: {row.value:.3g} ± {row.u:.2g} {row.unit}")
        print(f"  truth {truth[row.quantity]:.3g}, {where} the interval")""",
    ),
    (
        "markdown",
        "## The spectrum\n\nThe same noise by frequency: lines of a motor or the mains would stand out here.",
    ),
    ("code", 'ic.plot(ic.psd(still, sample_rate=rate, units="deg/s"));'),
    (
        "markdown",
        """## Numbers for a filter

In the units and the convention of the program that reads them, here Kalibr. What the record cannot give is said in
the block itself.""",
    ),
    ("code", 'print(filter_block(found, "kalibr").text)'),
    (
        "markdown",
        """## A record that is too short

Ten minutes cannot tell how the bias wanders. A fit would give a number all the same; this is what comes out here.""",
    ),
    (
        "code",
        """short = ic.allan(still[:6000], sample_rate=rate, units="deg/s")
for row in short.rows:
    if row.quantity in truth and row.method == "result":
        print(f"{row.quantity}: {row.status}, {row.value:.2g} {row.unit}")
        if row.reason:
            print(f"  {row.reason}")""",
    ),
]
NOTEBOOKS = {"first_calibration": FIRST, "noise": NOISE}


def executed(cells: list[tuple[str, str]]) -> Any:
    """Return a notebook with its outputs, without what changes from run to run."""
    made = nbformat.v4.new_notebook()
    new = {"markdown": nbformat.v4.new_markdown_cell, "code": nbformat.v4.new_code_cell}
    made.cells = [new[kind](source, id=f"cell-{i}") for i, (kind, source) in enumerate(cells)]
    with tempfile.TemporaryDirectory() as folder:
        resources = {"metadata": {"path": folder}}
        NotebookClient(made, timeout=600, kernel_name="python3", resources=resources).execute()
    made.metadata = {"kernelspec": {"name": "python3", "display_name": "Python 3", "language": "python"}}
    for cell in made.cells:
        cell.metadata = {}
        if cell.cell_type == "code":
            cell.outputs = [one for one in cell.outputs if one.output_type != "stream" or one.name == "stdout"]
    return made


def texts_of(notebook: Any) -> list[Any]:
    """Return cells and the texts of their outputs, as far as these are compared."""
    found: list[Any] = []
    for cell in notebook.cells:
        outputs = cell.get("outputs", [])
        parts = [{kind: NOT_COMPARED.sub("", one["data"][kind]) for kind in TEXTS if kind in one.get("data", {})}
                 or one.get("text", "")
                 for one in outputs]  # fmt: skip
        found.append((cell.cell_type, cell.source, parts))
    return found


def write_page(name: str, notebook: Any) -> None:
    """Write a notebook as a page of the manual, its pictures next to it."""
    lines: list[str] = []
    for number, cell in enumerate(notebook.cells):
        if cell.cell_type == "markdown":
            lines += [cell.source, ""]
            continue
        lines += ["```{code-block} python", cell.source, "```", ""]
        for one in cell.outputs:
            data = one.get("data", {})
            if "image/png" in data:
                picture = f"{name}_{number}.png"
                (GALLERY / picture).write_bytes(base64.b64decode(data["image/png"]))
                lines += [f"![What the cell above draws]({picture})", ""]
            elif text := data.get("text/plain", one.get("text", "")):
                lines += ["```{code-block} text", *_ends(text.rstrip("\n").split("\n")), "```", ""]
    lines += [f"The notebook: {{download}}`{name}.ipynb`. It is made, and tried, by `docs/notebooks.py`.", ""]
    (GALLERY / f"{name}.md").write_text("\n".join(lines), encoding="utf-8")


def _ends(lines: list[str]) -> list[str]:
    """Return the first and the last lines of a long output; the notebook has them all."""
    left = len(lines) - FIRST_LINES - LAST_LINES
    return lines if left < 2 else [*lines[:FIRST_LINES], f"... {left} more lines", *lines[-LAST_LINES:]]


def main() -> int:
    """Make or check all notebooks; return the exit status."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--check", action="store_true")
    check = parser.parse_args().check
    os.environ.setdefault("PYTHONWARNINGS", "ignore")
    os.environ["COLUMNS"] = "200"
    wrong = 0
    for name, cells in NOTEBOOKS.items():
        path, made = GALLERY / f"{name}.ipynb", executed(cells)
        if not check:
            path.write_text(json.dumps(made, indent=1, ensure_ascii=False, sort_keys=True) + "\n", encoding="utf-8")
            write_page(name, made)
        elif texts_of(made) != texts_of(nbformat.read(path, as_version=4)):
            print(f"{path.name} shows other outputs now: python docs/notebooks.py", file=sys.stderr)
            wrong = 1
    return wrong


if __name__ == "__main__":
    sys.exit(main())
