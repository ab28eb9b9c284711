"""The registry of rigs: known without loading, open to installed packages, closed to those that are broken."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from inertialcal.core.errors import UsageError
from inertialcal.core.registry import Registry
from inertialcal.rigs import BUILT_IN, DEMONSTRATED, RIGS, titles
from inertialcal.rigs.protocol import Rig
from inertialcal.rigs.twin import Twin

HEAVY = ("numpy", "scipy", "numba", "pydantic", "matplotlib")
MANUAL = (Path(__file__).parents[2] / "docs" / "howto" / "own_parts.md").read_text(encoding="utf-8")
TOY = MANUAL.partition("## A rig of your own")[2].partition("```python\n")[2].partition("```")[0]
SESSION = """
import sys
from inertialcal.cli.__main__ import main
for words in {commands!r}:
    try:
        main(words)
    except SystemExit as end:
        print("STATUS", end.code)
"""


def add_package(folder: Path, name: str, points: dict[str, str], **modules: str) -> None:
    """Put a package with entry points into a folder, as an installer would."""
    info = folder / f"{name.replace('-', '_')}-1.0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n", encoding="utf-8")
    lines = [f"{point} = {value}" for point, value in points.items()]
    (info / "entry_points.txt").write_text("\n".join(["[inertialcal.rigs]", *lines, ""]), encoding="utf-8")
    for module, text in modules.items():
        (folder / f"{module}.py").write_text(text, encoding="utf-8")


def python(code: str, *paths: Path) -> str:
    """Return what a process of its own prints."""
    path = os.pathsep.join([*map(str, paths), os.environ.get("PYTHONPATH", "")])
    done = subprocess.run(  # noqa: PLW1510 - asserted below
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        timeout=300,
        env={**os.environ, "PYTHONPATH": path},
    )
    assert done.returncode == 0, done.stderr
    return done.stdout + done.stderr


def registry(monkeypatch: pytest.MonkeyPatch, folder: Path) -> Registry[Rig]:
    """Return the registry as it is in a process that is started with a folder of packages."""
    monkeypatch.syspath_prepend(str(folder))
    return Registry("rig", Rig, "inertialcal.rigs", RIGS.built_in)


def test_names_and_titles_are_known_without_loading_a_rig() -> None:
    code = (
        "import sys\nfrom inertialcal.rigs import RIGS, titles\n"
        "from inertialcal.cli.options import rigs_beginning\n"
        "print(list(RIGS), titles(), rigs_beginning('s'), 'mesa' in RIGS)\n"
        f"print('LOADED', [name for name in {HEAVY!r} if name in sys.modules],"
        " [name for name in sys.modules if name.endswith('.rig')])\n"
    )
    assert python(code).rstrip().endswith("LOADED [] []")


@pytest.mark.parametrize("name", BUILT_IN)
def test_each_rig_is_loaded_alone(name: str) -> None:
    rig = RIGS[name]
    assert (rig.name, rig.title) == (name, titles()[name])
    assert rig is RIGS.named(name)


def test_the_rig_that_is_demonstrated_is_built_in() -> None:
    assert DEMONSTRATED in BUILT_IN


def test_a_rig_of_another_package_is_simulated_run_and_scored(tmp_path: Path) -> None:
    add_package(tmp_path / "site", "toy-rig", {"toy": "toy_rig:RIG"}, toy_rig=TOY)
    folder = str(tmp_path / "twin")
    commands = [
        ["simulate", "toy", "-o", folder, "--seed", "5"],
        ["run", folder, "--quiet"],
        ["score", folder, "--json"],
        ["score", "--rig", "toy", "--n", "2", "--json", "--quiet"],
        ["demo", "toy", "-o", str(tmp_path / "demo"), "--quiet"],
        ["simulate", "toy", "-o", folder + "_short", "--fault", "short"],
        ["simulate", "--help"],
    ]
    out = python(SESSION.format(commands=commands), tmp_path / "site")
    said = out.split("STATUS")
    assert [int(part.split()[0]) for part in said[1:]] == [0] * len(commands)
    one, many = (json.loads(said[at][said[at].index("{") :]) for at in (2, 3))
    assert (one["rig"], one["seed"], one["known"]) == ("toy", 5, 1)
    assert [(row["quantity"], row["n"]) for row in many["results"]] == [("angle_random_walk", 2)]
    assert (
        json.loads((tmp_path / "demo" / ".truth" / "truth.json").read_text("utf-8"))["seed"] == 1
    )  # of every demonstration
    assert json.loads((tmp_path / "twin_short" / ".truth" / "truth.json").read_text("utf-8"))["fault"] == "short"
    assert (
        "climate, shaker, turned_mass, satellite, station, flights, flights_recorded, heads, alignment, toy."
        in " ".join(said[-2].split())
    )


def test_the_package_of_a_rig_is_named_without_loading_it(tmp_path: Path) -> None:
    add_package(tmp_path, "toy-rig", {"toy": "no_such_module:RIG"})
    assert "of the package toy-rig 1.0" in python(
        "from inertialcal.rigs import titles\nprint(titles()['toy'])", tmp_path
    )


@pytest.mark.parametrize(
    ("module", "what"),
    [
        ("raise RuntimeError('no licence')", r"rig 'toy' of toy-rig 1.0 cannot be loaded \(RuntimeError: no licence\)"),
        ("import module_that_is_not_there", "cannot be loaded .ModuleNotFoundError: No module named"),
        ("", "cannot be loaded .AttributeError"),
        ("RIG = {}", "rig 'toy' of toy-rig 1.0 is a dict, not a Rig"),
        (TOY.replace('Rig("toy"', 'Rig("other"'), "rig 'toy' of toy-rig 1.0 calls itself 'other'"),
    ],
)
def test_a_broken_package_is_one_clear_error(
    module: str, what: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    name = f"broken_{len(module)}"
    add_package(tmp_path, "toy-rig", {"toy": f"{name}:RIG"}, **{name: module})
    rigs = registry(monkeypatch, tmp_path)
    with pytest.raises(UsageError, match=what) as caught:
        rigs.named("toy")
    (problem,) = caught.value.problems
    assert (problem.code, problem.where) == ("broken_plugin", f"{name}:RIG")
    assert rigs.named("mesa") is RIGS["mesa"]


def test_two_packages_with_a_rig_of_one_name_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    add_package(tmp_path, "toy-rig", {"toy": "one:RIG"})
    add_package(tmp_path, "other-rig", {"toy": "other:RIG"})
    with pytest.raises(UsageError, match=r"rig .toy. is added by toy-rig 1\.0 and other-rig 1\.0"):
        registry(monkeypatch, tmp_path).named("toy")


def test_a_package_cannot_take_the_place_of_a_built_in_rig(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    add_package(tmp_path, "toy-rig", {"mesa": "no_such_module:RIG"})
    rigs = registry(monkeypatch, tmp_path)
    assert rigs.named("mesa") is RIGS["mesa"]
    assert list(rigs)[: len(BUILT_IN)] == list(BUILT_IN)  # the toy of another test may stand behind them
    with pytest.raises(UsageError, match="'mesa' is built in"):
        rigs["mesa"] = RIGS["mesa"]


def test_a_program_adds_a_rig_of_its_own_and_takes_it_away() -> None:
    def make(seed: int, changes: object) -> Twin:
        raise AssertionError

    rigs = Registry("rig", Rig, "inertialcal.none", RIGS.built_in)
    rigs["own"] = own = Rig("own", "its own", make)
    assert rigs.named("own") is own
    assert (list(rigs)[-1], len(rigs), "own" in rigs) == ("own", len(BUILT_IN) + 1, True)
    del rigs["own"]
    assert rigs.get("own") is None
    with pytest.raises(UsageError, match=r"no rig 'own'\. There are: rate_table, "):
        rigs.named("own")
