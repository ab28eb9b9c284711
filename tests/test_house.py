"""The house: one folder a row, imports only upwards, nothing imports the package root, kernels alone."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
import tomllib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import pytest

from inertialcal.procedures import BUILT_IN

PACKAGE = Path(__file__).resolve().parents[1] / "src" / "inertialcal"

# DESIGN, "The house": a folder imports from itself and from folders above it. Files stand above procedures, so that
# one can read its own tables and schedules.
ORDER = (
    "core", "statistics", "signals", "physics", "sensors", "files", "rigs", "procedures", "report", "campaign",
    "archive", "lots", "lab", "cli",
)  # fmt: skip
FILES = sorted(PACKAGE.rglob("*.py"))
STUBS = sorted(PACKAGE.rglob("*.pyi"))
HEAVY = ("numpy", "scipy", "numba", "yaml", "matplotlib", "pandas", "pyarrow", "h5py", "pydantic")


def folder(path: Path) -> str:
    parts = path.relative_to(PACKAGE).parts
    return parts[0] if len(parts) > 1 else ""


def of_each(files: Sequence[Path]) -> Callable[[Callable[[Path], None]], Callable[[], None]]:
    """Return what makes one test of a check of files: a test for each would take longer to collect than to run."""

    def made(check: Callable[[Path], None]) -> Callable[[], None]:
        def test() -> None:
            wrong = []
            for path in files:
                try:
                    check(path)
                except AssertionError as error:
                    wrong.append(f"{path.relative_to(PACKAGE)}: {error}")
            assert not wrong, "\n".join(wrong)

        test.__doc__ = check.__doc__
        return test

    return made


@dataclass(frozen=True)
class Names:
    """Line and absolute name of every import of a file, inside functions too, and the names that it calls."""

    imported: tuple[tuple[int, str], ...]
    called: frozenset[str]


@cache
def names(path: Path) -> Names:
    """Return what a file names; it is parsed once for all tests."""
    package = ("inertialcal", *path.relative_to(PACKAGE).parts[:-1])
    nodes = list(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))
    calls = [node.func for node in nodes if isinstance(node, ast.Call)]
    called = frozenset(function.id for function in calls if isinstance(function, ast.Name))
    return Names(tuple(one for node in nodes for one in imports(node, package)), called)


def imports(node: ast.AST, package: tuple[str, ...]) -> Iterator[tuple[int, str]]:
    if isinstance(node, ast.Import):
        yield from ((node.lineno, alias.name) for alias in node.names)
    elif isinstance(node, ast.ImportFrom):
        base = package[: len(package) - node.level + 1] if node.level else ()
        module = ".".join([*base, *([node.module] if node.module else [])])
        yield node.lineno, module
        if node.level:  # "from . import x" may name a module
            yield from ((node.lineno, f"{module}.{alias.name}") for alias in node.names)


def test_every_folder_stands_in_the_order() -> None:
    found = {path.name for path in PACKAGE.iterdir() if path.is_dir() and path.name not in {"__pycache__", "examples"}}
    assert found <= set(ORDER)
    assert all((PACKAGE / name / "__init__.py").is_file() for name in found)


@of_each([p for p in FILES if folder(p)])
def test_imports_go_upwards_only(path: Path) -> None:
    own = ORDER.index(folder(path))
    for line, name in names(path).imported:
        parts = name.split(".")
        if parts[0] != "inertialcal":
            continue
        assert len(parts) > 1, f"{path.name}:{line} imports the package root"
        if parts[1] in ORDER:
            assert ORDER.index(parts[1]) <= own, f"{path.name}:{line} imports {name} from a lower folder"


def modules() -> dict[str, Path]:
    """Return the file of each module by its dotted name."""
    named = {".".join(("inertialcal", *path.relative_to(PACKAGE).with_suffix("").parts)): path for path in FILES}
    return {name.removesuffix(".__init__"): path for name, path in named.items()}


def run_imports(path: Path, package: tuple[str, ...]) -> Iterator[str]:
    """Yield what a file imports when it runs, inside functions too; what only types need is left out."""
    left: list[ast.AST] = [*ast.parse(path.read_text(encoding="utf-8")).body]
    while left:
        node = left.pop()
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            left += node.orelse
            continue
        yield from (name for _, name in imports(node, package))
        left += [*ast.iter_child_nodes(node)]


def rings(graph: dict[str, set[str]]) -> list[str]:
    """Return the modules that import themselves, by way of others."""
    reached = {name: set(graph[name]) for name in graph}
    for name, imported in graph.items():
        left = [*imported]
        while left:
            more = graph[left.pop()] - reached[name]
            reached[name] |= more
            left += more
    return sorted(name for name in graph if name in reached[name])


def test_no_import_goes_round() -> None:
    """An import inside a function hides a ring from Python, not from a reader."""
    known = modules()
    packages = {name: tuple(name.split(".")) if path.name == "__init__.py" else tuple(name.split(".")[:-1])
                for name, path in known.items()}  # fmt: skip
    graph = {name: {one for one in run_imports(path, packages[name]) if one in known} for name, path in known.items()}
    # "from a import b" where b is a module: what is meant is the module, not its package
    graph = {name: {one for one in found if not any(other.startswith(f"{one}.") for other in found)}
             for name, found in graph.items()}  # fmt: skip
    assert rings(graph) == []


def test_rings_are_found() -> None:
    assert rings({"a": {"b"}, "b": {"c"}, "c": {"a"}, "d": {"a"}}) == ["a", "b", "c"]


MOST_FILES = 20  # in a folder: beyond that it lacks a level, or holds pieces too small


@pytest.mark.parametrize("root", [PACKAGE, Path(__file__).parent], ids=["src", "tests"])
def test_a_folder_holds_what_a_reader_can_survey(root: Path) -> None:
    counts = {path: len([*path.glob("*.py")]) for path in [root, *root.rglob("*")] if path.is_dir()}
    assert {str(path.relative_to(root)): count for path, count in counts.items() if count > MOST_FILES} == {}


def test_the_walk_sees_relative_imports(tmp_path: Path) -> None:
    path = PACKAGE / "core" / "estimate.py"
    assert "inertialcal.core.errors" in {name for _, name in names(path).imported}


@of_each(FILES)
def test_loops_are_compiled_in_kernels_only_and_never_assume_finite_values(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    if not re.fullmatch(r"_kernels(_[a-z_]+)?\.py", path.name):
        assert "numba" not in {name.split(".")[0] for _, name in names(path).imported}
    assert not re.search(r"fastmath\s*=\s*True|['\"](nnan|ninf|fast)['\"]", text)


@of_each(FILES)
def test_no_pickle_no_eval(path: Path) -> None:
    assert not names(path).called & {"eval", "exec", "compile", "__import__"}
    imported = {name.split(".")[0] for _, name in names(path).imported}
    assert not imported & {"pickle", "dill", "joblib", "shelve", "marshal"}
    assert "yaml" not in imported or path.name in {"kalibr.py", "yaml_text.py"}  # writing; reading: plain content only


# The engine asks the procedure objects and names none. These are still to be emptied: the list may only shrink.
STILL_NAME_PROCEDURES: frozenset[str] = frozenset({})
# Words of budgets (GUM), of kinds of terms and of use, too: procedures of these names are told by their imports
WORDS = ("sensitivity", "vibration")
PROCEDURE_NAMES = re.compile(rf"\b({'|'.join(one for one in BUILT_IN if one not in WORDS)})\b")


def names_of_procedures(path: Path) -> list[str]:
    """Return each line of a file where a procedure is imported, or named in a string that is no docstring."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    heads = (ast.Module, ast.ClassDef, ast.FunctionDef)
    bodies = (node.body for node in ast.walk(tree) if isinstance(node, heads))
    docs = {id(body[0].value) for body in bodies if body and isinstance(body[0], ast.Expr)}
    found = [
        f"{path.name}:{line} imports {name}"
        for line, name in names(path).imported
        if name.startswith("inertialcal.procedures.") and name.split(".")[2] in BUILT_IN
    ]
    texts = (node for node in ast.walk(tree) if isinstance(node, ast.Constant) and id(node) not in docs)
    for node in texts:
        if isinstance(node.value, str) and PROCEDURE_NAMES.search(node.value):
            found.append(f"{path.name}:{node.lineno} says {node.value!r}")
    return found


@of_each([p for p in FILES if folder(p) == "campaign"])
def test_campaigns_name_no_procedure(path: Path) -> None:
    messages = (
        "no recording of a rate table or a flip",
        "flip tables of means",
        "laid into many",
    )  # of `init`, for people
    assert not [one for one in names_of_procedures(path) if not any(text in one for text in messages)]


@of_each(
    [p for p in FILES if folder(p) == "report" and not (p.parents[1].name == "figures" and p.parent.name in BUILT_IN)]
)
def test_the_report_names_no_procedure_but_the_folders_of_their_figures(path: Path) -> None:
    calls = "Give what run, rate_table, read"  # of a message for people
    columns = "says 'heads'"  # of a table
    assert not [one for one in names_of_procedures(path) if calls not in one and columns not in one]


def test_no_curve_has_the_name_of_one_of_another_procedure() -> None:
    """The figures of both would be drawn from the curves of either."""
    owners: dict[str, set[str]] = {}
    for path in (PACKAGE / "procedures").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "Curve" and node.args:
                name, owner = node.args[0], path.relative_to(PACKAGE / "procedures").parts[0]
                if isinstance(name, ast.Constant):
                    owners.setdefault(str(name.value), set()).add(owner)
    assert len(owners) > 30
    assert not {name: found for name, found in owners.items() if len(found) > 1}


def test_sensitivity_changed_three_existing_files() -> None:
    """A procedure is added in folders of its own: the rest has its name, its standards and its signature, once each."""
    own = ("procedures/sensitivity/", "report/figures/sensitivity/", "rigs/")
    said = re.compile(
        r'^BUILT_IN = [^)]*"sensitivity"|"(?:supply_meter|pressure_gauge)|^def sensitivity\(', re.MULTILINE
    )
    found = set()
    for path in [*PACKAGE.rglob("*.py"), *PACKAGE.rglob("*.pyi")]:
        place = path.relative_to(PACKAGE).as_posix()
        imported = [] if path.suffix == ".pyi" else [name for _, name in names(path).imported]
        uses = any(name.startswith("inertialcal.procedures.sensitivity") for name in imported)
        if not place.startswith(own) and (uses or said.search(path.read_text(encoding="utf-8"))):
            found.add(place)
    assert found == {"procedures/__init__.py", "core/schema/standards.py", "campaign/calls/nouns.pyi"}


@pytest.mark.parametrize("line", ["from ..procedures.flip import plan", "kind == 'flip'", "what = 'no flip here'"])
def test_the_search_for_procedures_finds_them(tmp_path: Path, line: str, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "campaign" / "wrong.py"
    path.parent.mkdir()
    path.write_text(line, encoding="utf-8")
    monkeypatch.setitem(globals(), "PACKAGE", tmp_path)
    assert names_of_procedures(path)


def test_tests_mirror_the_tree() -> None:
    tests = Path(__file__).parent
    for path in tests.rglob("test_*.py"):
        where = path.relative_to(tests).parts
        assert len(where) == 1 or where[0] in {
            *ORDER,
            "docs",
            "independent",
            "kept",
            "speed",
            "newcomers",
            "plugin",
            "torture",
        }, f"{path} mirrors no folder"


def test_importing_the_package_loads_nothing_heavy() -> None:
    code = f"import sys, inertialcal\nprint([name for name in {HEAVY!r} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout.strip() == "[]"


def test_plans_and_procedures_load_nothing_heavy() -> None:
    code = (
        "import sys\nfrom importlib import import_module\n"
        "from inertialcal.procedures import BUILT_IN, procedure_of\n"
        "from inertialcal.core.settings import settings_of\n"
        "for name in BUILT_IN:\n    import_module(f'inertialcal.procedures.{name}.plan')\n"
        "    settings_of(procedure_of(name).plan_type)\n"
        f"print([name for name in {HEAVY!r} if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout.strip() == "[]"


# Fields that programs read are typed: a name, condition, reason or remark is text for people, taken apart nowhere.
TEXTS = frozenset(
    {"name", "names", "condition", "conditions", "reason", "reasons", "what", "remark", "quantity", "source"}
)
SINGLE = TEXTS - {"names", "conditions", "reasons", "source"}  # of which ``in`` and an index look inside the text
PARTING = frozenset({"startswith", "endswith", "partition", "rpartition", "split", "rsplit", "removeprefix",
                     "removesuffix", "find", "fullmatch", "match", "search", "sub"})  # fmt: skip
# The serialiser, and what reads texts that come from outside: names of files, columns and channels, words of commands.
SERIALISER = ("core/remarks.py", "core/influence.py")
INPUT = ("files/", "cli/options.py", "campaign/models/inputs.py",
         "campaign/calls/document.py", "procedures/positions/given.py", "procedures/given.py",
         "core/schema/settings.py",
         "report/sections.py")  # fmt: skip


def told(node: ast.AST) -> str:
    """Return the word by which an expression ends: ``row.reason``, ``row["reason"]``, ``str(reason)``: reason."""
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "str" and node.args:
        return told(node.args[0])
    if isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Constant):
        return str(node.slice.value)
    if isinstance(node, ast.Attribute) and node.attr == "text":  # of a Reason
        return told(node.value)
    return node.attr if isinstance(node, ast.Attribute) else node.id if isinstance(node, ast.Name) else ""


def takes_apart(node: ast.AST) -> bool:
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in PARTING:
        return any(told(one) in TEXTS for one in (node.func.value, *node.args))
    if isinstance(node, ast.Compare) and isinstance(node.ops[0], ast.In | ast.NotIn):
        return told(node.comparators[0]) in SINGLE
    if isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Slice | ast.UnaryOp | ast.Constant):
        inside = not isinstance(node.slice, ast.Constant) or isinstance(node.slice.value, int)
        return inside and told(node.value) in SINGLE
    return False


@pytest.mark.parametrize(
    "code",
    ['name.rpartition("_")', 'row["reason"].startswith("yes")', 'str(row["condition"])[4:]', "name[-1]",
     '" alone" in row.condition', 'remark.what.endswith("is not read")', "FLIP.fullmatch(condition)",
     're.sub("a", "b", one.reason.text)'],
)  # fmt: skip
def test_the_walk_sees_what_takes_a_text_apart(code: str) -> None:
    assert any(takes_apart(node) for node in ast.walk(ast.parse(code)))


def test_no_code_takes_a_name_condition_reason_or_remark_apart() -> None:
    found = [
        f"{path.relative_to(PACKAGE)}:{getattr(node, 'lineno', '')}: {ast.unparse(node)}"
        for path in FILES
        if not str(path.relative_to(PACKAGE)).startswith((*SERIALISER, *INPUT))
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if takes_apart(node)
    ]
    assert not found


# ``Any`` in a public signature says "read the code". It stands only where no name could say more.
OPEN = frozenset({"NDArray", "Procedure", "Tested"})  # the type of the file; all procedures alike
JSON = frozenset({"Mapping", "dict"})  # of str: an object of JSON
# What stays, and why; the list may only shrink.
ANY_BY_ITSELF = {
    "core/schema/quantities.py:quantity": "a type for pydantic: annotations of fields are made of it",
    "core/settings.py:setting": "stands for the value of a field, as dataclasses.field does",
    "core/settings.py:fact": "the same",
    "campaign/calls/call.py:Reduced.result": "of whichever procedure",
    "campaign/calls/call.py:Reduced.plan": "the same",
    "campaign/calls/call.py:Reduced.shown": "the same",
    "campaign/engine/engine.py:Prepared.plan": "the same",
    "campaign/engine/engine.py:Prepared.readings": "the same",
    "campaign/models/build.py:Part.result": "the same",
    "core/curve.py:Column.values": "numbers of any type, or words",
    "core/settings.py:Setting.kind": "a type with its arguments",
    "core/settings.py:Setting.table": "a type whose fields are settings",
    "procedures/protocol.py:Reduced.result": "the same",
    "procedures/protocol.py:Reduced.plan": "the same",
    "procedures/protocol.py:Reduced.shown": "the same",
    "cli/nouns/factory.py:option_of": "annotations that the parser makes options of",
    "cli/options.py:with_options": "the same",
    "files/text/delimited.py:arrow_numbers": "a column of Arrow, which has no types",
    "report/numbers.py:Branch.get": "a value of JSON: the key tells its type, and only to the reader",
    "report/numbers.py:wrap": "the same",
    "report/plot.py:plot": "Axes or an array of them, as matplotlib says it itself: callers know which",
}


def bare_any(node: ast.expr) -> bool:
    """Return whether an annotation holds an ``Any`` that could be named."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return bare_any(ast.parse(node.value, mode="eval").body)
    if isinstance(node, ast.Subscript) and isinstance(node.value, ast.Name):
        given = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        said = [ast.unparse(one) for one in given]
        if node.value.id in OPEN or (node.value.id in JSON and said == ["str", "Any"]):
            return False
        if node.value.id in {"Literal", "Annotated"}:  # words; a type, and what the parser says of it
            return node.value.id == "Annotated" and bare_any(given[0])
        if node.value.id == "Callable" and said[0] == "[Any]":  # a reader, called with what it says itself
            return bare_any(given[1])
    if isinstance(node, ast.Name | ast.Attribute):
        return ast.unparse(node) in {"Any", "typing.Any"}
    return any(bare_any(one) for one in ast.iter_child_nodes(node) if isinstance(one, ast.expr))


def annotated(function: ast.FunctionDef) -> Iterator[ast.expr]:
    """Yield the annotations of a signature, without ``**kwargs``, which are passed through."""
    args = function.args
    for one in (*args.posonlyargs, *args.args, args.vararg, *args.kwonlyargs):
        if one is not None and one.annotation is not None:
            yield one.annotation
    if function.returns is not None:
        yield function.returns


def public(body: Sequence[ast.stmt], prefix: str = "") -> Iterator[tuple[str, Sequence[ast.expr]]]:
    """Yield annotations of the public functions, methods and fields of a module, also of those below a condition."""
    for node in body:
        if isinstance(node, ast.FunctionDef) and not node.name.startswith("_"):
            yield prefix + node.name, [*annotated(node)]
        elif isinstance(node, ast.AnnAssign) and prefix and not ast.unparse(node.target).startswith("_"):
            yield prefix + ast.unparse(node.target), [node.annotation]
        elif isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
            yield from public(node.body, f"{prefix}{node.name}.")
        elif isinstance(node, ast.If):
            yield from public([*node.body, *node.orelse], prefix)


def with_bare_any(path: Path) -> set[str]:
    where = path.relative_to(PACKAGE)
    tree = ast.parse(path.read_text(encoding="utf-8"))
    return {f"{where}:{name}" for name, given in public(tree.body) if any(bare_any(one) for one in given)}


def test_public_signatures_name_their_types() -> None:
    """What compiles with numba takes any array; the rest is in the list above, which may only shrink."""
    files = [path for path in [*FILES, *STUBS] if not path.name.startswith("_kernels")]
    assert {one for path in files for one in with_bare_any(path)} == set(ANY_BY_ITSELF)


@pytest.mark.parametrize("annotation", ["Any", "list[Any]", "Any | None", "'Any'", "Mapping[tuple[str, str], Any]",
                                        "Callable[[Any], Any]", "Callable[..., Any]"])  # fmt: skip
def test_the_walk_sees_any(annotation: str) -> None:
    assert bare_any(ast.parse(annotation, mode="eval").body)


@pytest.mark.parametrize("annotation", ["NDArray[Any]", "Sequence[Mapping[str, Any]] | None", "Tested[Any, Any, Any]",
                                        "Callable[[Any], T]"])  # fmt: skip
def test_the_walk_allows_what_no_name_could_say(annotation: str) -> None:
    assert not bare_any(ast.parse(annotation, mode="eval").body)


# What is to go says what to write instead and when it goes, as docs/promise.md has it: a FutureWarning, or a remark.
DEPRECATED = re.compile(r"[Ww]rite \S.*; .* goes in (\d+)\.(\d+)")


def wrong_deprecations(code: str, version: tuple[int, int]) -> list[str]:
    """Return deprecations that do not say what the promise asks for, or that are due."""
    wrong = []
    for node in ast.walk(ast.parse(code)):
        if not isinstance(node, ast.Call):
            continue
        given = [*node.args, *(one.value for one in node.keywords)]
        if not {"FutureWarning", "'deprecated'"} & {ast.unparse(one) for one in given}:
            continue
        parts = [one.value for arg in given for one in ast.walk(arg) if isinstance(one, ast.Constant)]
        text = "".join(one for one in parts if isinstance(one, str))
        said = DEPRECATED.search(text)
        if said is None or (int(said[1]), int(said[2])) <= version:
            wrong.append(ast.unparse(node))
    return wrong


def test_what_is_deprecated_says_what_to_write_and_when_it_goes() -> None:
    project = tomllib.loads((PACKAGE.parents[1] / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    major, minor, _ = map(int, project["version"].split("."))
    found = {str(path.relative_to(PACKAGE)): wrong_deprecations(path.read_text(encoding="utf-8"), (major, minor))
             for path in FILES}  # fmt: skip
    assert {path: wrong for path, wrong in found.items() if wrong} == {}


@pytest.mark.parametrize(
    ("code", "right"),
    [('warn(f"Write {new}=; {old} goes in 0.4", FutureWarning)', True),
     ('warn("rate goes in 0.4", FutureWarning)', False), ('warn("Write b=", category=FutureWarning)', False),
     ('warn("Write b=; a goes in 0.2", FutureWarning, stacklevel=2)', False),
     ('Remark("deprecated", "warning", what, do="Write b; a goes in 1.0")', True),
     ('Remark("deprecated", "warning", "old")', False)],
)  # fmt: skip
def test_the_walk_sees_deprecations(code: str, right: bool) -> None:
    assert (wrong_deprecations(code, (0, 2)) == []) is right
