"""What is released: a wheel with all of the package, made of the source distribution; a page that leads somewhere."""

from __future__ import annotations

import re
import subprocess
import sys
import sysconfig
import tarfile
import tomllib
import venv
import zipfile
from email.parser import Parser
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[1]
RELATIVE = re.compile(r"\]\((?!https?://|#)")


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> zipfile.ZipFile:
    folder = tmp_path_factory.mktemp("package")
    build = (sys.executable, "-m", "hatchling", "build", "-d", str(folder), "-t")
    subprocess.run([*build, "sdist"], cwd=ROOT, check=True, capture_output=True)
    with tarfile.open(next(folder.glob("*.tar.gz"))) as packed:
        packed.extractall(folder, filter="data")
    subprocess.run([*build, "wheel"], cwd=next(folder.glob("inertialcal-*/")), check=True, capture_output=True)
    return zipfile.ZipFile(next(folder.glob("*.whl")))


def test_wheel_of_the_source_distribution_is_the_package(wheel: zipfile.ZipFile) -> None:
    here = {
        path.relative_to(ROOT / "src").as_posix()
        for path in (ROOT / "src/inertialcal").rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    assert {name for name in wheel.namelist() if ".dist-info/" not in name} == here
    assert "inertialcal/py.typed" in wheel.namelist()


PROGRAM = Path(__file__).parent / "docs/typed_program.py"


@pytest.mark.slow
def test_a_program_of_others_is_typed_throughout(wheel: zipfile.ZipFile, tmp_path: Path) -> None:
    """As the package is installed, with ``py.typed``; names and arguments that are not there are errors."""
    venv.create(tmp_path / "env", symlinks=True)
    python = tmp_path / "env/bin/python"
    site = Path(sysconfig.get_path("purelib", vars={"base": str(tmp_path / "env")}))
    wheel.extractall(site)
    (site / "needed.pth").write_text(sysconfig.get_path("purelib"), encoding="utf-8")
    wrong = tmp_path / "wrong.py"
    wrong.write_text("import inertialcal as ic\n\nic.rate_tabel\nic.flip('a.csv', positons=None)\n", encoding="utf-8")
    strict = ("--strict", "--python-executable", str(python), "--cache-dir", str(tmp_path / "cache"))
    done = subprocess.run([sys.executable, "-m", "mypy", *strict, "--config-file=", str(PROGRAM), str(wrong)],
                          cwd=tmp_path, check=False, capture_output=True, text=True)  # fmt: skip
    told = [line for line in done.stdout.splitlines() if "error:" in line]
    assert [line.rpartition("[")[2] for line in told] == ["attr-defined]", "call-arg]"], done.stdout


def test_page_of_an_index_has_no_link_that_leads_nowhere(wheel: zipfile.ZipFile) -> None:
    metadata = next(name for name in wheel.namelist() if name.endswith("METADATA"))
    stated = Parser().parsestr(wheel.read(metadata).decode())
    assert stated["Version"] == tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["version"]
    assert stated["Author"]
    page = str(stated.get_payload())
    assert "pip install inertialcal" in page
    assert not RELATIVE.search(page)


def test_recipe_and_citation_follow_the_project() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    recipe = (ROOT / "packaging/conda/meta.yaml").read_text("utf-8")
    (version,) = re.findall(r'set version = "(.+)"', recipe)
    run = recipe[recipe.index("\n  run:") : recipe.index("\ntest:")]
    needed = {line.replace(" ", "").replace("matplotlib-base", "matplotlib") for line in re.findall(r"- (.+)", run)}
    assert needed == {*project["dependencies"], f"python{project['requires-python']}"}
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text("utf-8"))
    assert {version, cited["version"]} == {project["version"]}
    assert {recipe.split("license: ")[1].split()[0], cited["license"]} == {project["license"]}


def test_oldest_dependencies_are_those_that_the_project_states() -> None:
    """Renewed by ``make pins``; as the newest, each with its hash and without the address of an index."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    extras = project["optional-dependencies"]
    stated = [*project["dependencies"], *(one for name in ("frame", "pdf", "sign", "formats", "test", "build")
                                          for one in extras[name])]  # fmt: skip
    pins = (ROOT / "requirements-oldest.txt").read_text("utf-8")
    assert "://" not in pins
    resolved = dict(re.findall(r"^([\w-]+)==([\w.]+)", pins, re.MULTILINE))
    for one in stated:
        name, least = one.lower().split(">=")
        assert f"{resolved[name]}.".startswith(f"{least}."), one


def test_links_lead_to_the_files_of_the_version_where_the_address_is_known() -> None:
    sys.path.insert(0, str(ROOT / "packaging"))
    try:
        from readme import for_an_index
    finally:
        sys.path.pop(0)
    text = "![A page](docs/a.png) of [words](docs/words.md), [there](https://example.org/x), [here](#below)"
    home = "https://example.org/inertialcal"
    assert for_an_index(text, home, "1.2.3") == (
        f"![A page]({home}/raw/v1.2.3/docs/a.png) of [words]({home}/blob/v1.2.3/docs/words.md), "
        "[there](https://example.org/x), [here](#below)"
    )
    assert for_an_index(text, "", "1.2.3") == " of words, [there](https://example.org/x), [here](#below)"
    for target in re.findall(r"\]\((?!https?://|#)([^)#\s]+)", (ROOT / "README.md").read_text("utf-8")):
        assert (ROOT / target).is_file()


def test_the_paper_cites_what_it_lists_and_states_the_figures_of_the_manual() -> None:
    paper, listed, audit, project = (
        " ".join((ROOT / name).read_text("utf-8").split())
        for name in ("paper/paper.md", "paper/paper.bib", "docs/source_audit.md", "pyproject.toml")
    )
    assert set(re.findall(r"@([a-z]+\d*)\b", paper)) == set(re.findall(r"@[a-z]+\{(\w+),", listed))
    said = re.search(r"Of (\d+) printed figures .*? (\d+) follow .*? (\d+) do not \((\d+) causes.*? of (\d+) it", paper)
    found = re.search(r"Of (\d+) figures .*?\*\*(\d+) hold\*\*.*?; (\d+) do not, from (\d+) .*? of (\d+) it", audit)
    assert said is not None
    assert found is not None
    assert said.groups() == found.groups()
    assert re.findall(r"Version (\S+) covers", paper) == re.findall(r'name = "inertialcal" version = "(\S+)"', project)
    assert 250 <= len(paper.split()) <= 1000  # the form of the journal
