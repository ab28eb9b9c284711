"""The simulators import nothing of inertialcal, at any depth: a shared mistake would be invisible."""

from __future__ import annotations

import ast
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).parent
CALLERS = {"trial", "gate", "coverage", "screened"}  # these call the commands, and no simulator may import them
SIMULATORS = sorted(
    path.stem for path in FOLDER.glob("*.py") if path.stem not in CALLERS and not path.stem.startswith(("test_", "__"))
)
ALLOWED = {"numpy", "scipy", "pyarrow", "h5py", *sys.stdlib_module_names}


def imported(path: Path) -> tuple[set[str], set[str]]:
    """Return packages that a module imports, and modules of this folder."""
    packages, here = set(), set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            packages |= {name.name.split(".")[0] for name in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            packages.add((node.module or "").split(".")[0])
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 1, f"{path.name}: an import from above the folder"
            here |= {node.module} if node.module else {name.name for name in node.names}
        elif isinstance(node, ast.Call) and getattr(node.func, "id", getattr(node.func, "attr", "")) in (
            "__import__", "import_module",
        ):  # fmt: skip
            pytest.fail(f"{path.name}:{node.lineno}: an import at run time cannot be checked")
    return packages, {name for name in here if name}


def test_each_simulator_is_checked() -> None:
    assert {
        "bases",
        "case",
        "clean",
        "variations",
        "faults",
        "flip",
        "moved_mass",
        "positions",
        "rate_table",
        "static",
        "thermal",
    } <= set(SIMULATORS)


@pytest.mark.parametrize("name", SIMULATORS)
def test_simulators_import_numpy_scipy_and_each_other_only(name: str) -> None:
    packages, here = imported(FOLDER / f"{name}.py")
    assert packages <= ALLOWED, f"{name} imports {packages - ALLOWED}"
    assert here <= set(SIMULATORS), f"{name} imports {here - set(SIMULATORS)}"
