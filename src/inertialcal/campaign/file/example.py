"""The examples: published campaigns that ship with the package, and simulated ones that are made."""

from __future__ import annotations

import json
import shlex
from importlib.resources import as_file, files
from pathlib import Path

from ...core.campaign_text import FILE
from ...core.errors import UsageError
from ...core.schema.toml import parse_toml
from ...files.source import read_bytes
from ...files.write.atomic import write_folder
from ...rigs import DEMONSTRATED, RIGS
from ..outcome.publish import OUT
from ..twins.twin import TRUTH, simulate
from .load import load


def examples() -> list[str]:
    """Return the names of the examples."""
    root = files("inertialcal") / "examples"
    return sorted(entry.name for entry in root.iterdir() if (entry / FILE).is_file())


DEFAULT = "inertialcal-demo"  # folder of an example; its name follows, but for the plain one
PLAIN = "npsat2011"


def demonstration(name: str, target: Path | None) -> tuple[str, Path]:
    """Return which example to show, and the folder it goes to: `target`, or one with its name in this folder.

    Raises
    ------
    UsageError
        If there is none of that name.
    """
    known = [*examples(), *RIGS]
    if name and name not in known:
        raise UsageError(f"no example {name!r}", do=f"There are: {', '.join(known)}. A folder is given by -o")
    one = name or DEMONSTRATED
    return one, target or Path(DEFAULT if one == PLAIN else f"{DEFAULT}-{one}")


def build(name: str, target: Path) -> Path:
    """Copy a published example, or simulate a rig, into a folder; return the folder.

    Raises
    ------
    UsageError, StoreError
        As `copy_example`.
    """
    if name in examples():
        return copy_example(name, target)
    if (target / FILE).is_file():
        return _same(name, target)
    return simulate(name, target, RIGS.named(name).demonstration_seed).folder


def has_truth(folder: Path) -> bool:
    """Tell whether the truth of a campaign lies beside it."""
    return (folder / TRUTH).is_file()


def title(name: str) -> str:
    """Return one line on an example, as its campaign file has it."""
    if name not in examples():
        return f"a simulated campaign of the rig {name}, seed {RIGS.named(name).demonstration_seed}"
    with as_file(files("inertialcal") / "examples" / name) as source:
        campaign = load(source).file.campaign
    return f"{campaign.title} ({campaign.source})"


def copy_example(name: str, target: Path) -> Path:
    """Copy an example into a folder of the user's, and return that folder.

    A folder that already holds the same campaign is used as it is, with its changes.

    Raises
    ------
    UsageError
        If there is no example of that name, or something else stands where it should go, be it another campaign.
    StoreError
        If the folder cannot be written.
    """
    if name not in examples():
        raise UsageError(f"no example {name!r}", do=f"There are: {', '.join(examples())}")
    if (target / FILE).is_file():
        return _same(name, target)
    if target.exists() and (not target.is_dir() or any(target.iterdir())):
        do = f"Name another folder: inertialcal demo {name} -o FOLDER"
        raise UsageError(f"{target} exists and is no campaign", do=do)
    with as_file(files("inertialcal") / "examples" / name) as source:
        named = {path.relative_to(source): path for path in source.rglob("*") if path.is_file()}
        own = {one: path for one, path in named.items() if one.parts[0] != OUT}
        write_folder(target, {one.as_posix(): path.read_bytes() for one, path in own.items()})
    return target


def _same(name: str, target: Path) -> Path:
    """Return a folder that holds the campaign of an example; a campaign of another name, or of a user, is not run."""
    published = name in examples()
    campaign = parse_toml(read_bytes(target / FILE), FILE)[1].get("campaign") if published else _truth(target)
    found = str(campaign.get("id" if published else "rig", "")) if isinstance(campaign, dict) else ""
    if found != name:
        here = shlex.quote(str(target))
        do = f"Name another folder: inertialcal demo {name} -o FOLDER. To run what is there: inertialcal run {here}"
        raise UsageError(f"{target} holds another campaign" + (f" ({found})" if found else ""), do=do)
    return target


def _truth(target: Path) -> object:
    """Return what lies sealed beside a simulated campaign; None where nothing does, or no JSON."""
    try:
        return json.loads(read_bytes(target / TRUTH)) if has_truth(target) else None
    except ValueError:
        return None
