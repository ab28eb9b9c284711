"""What a person guides from: a LAB.toml, or a name that stands for one with a single instrument.

Whatever is named becomes a LAB.toml, which the recording keeps.
"""

from __future__ import annotations

import os
import re
import stat
from pathlib import Path

import numpy as np

from ...core.campaign_text import toml_text
from ...core.errors import UsageError
from ...files.info.motion import triad
from ...rigs import RIGS
from ..acquisition.lab_file import Lab, lab_of, load_lab

NAME, PHONE = "imu", "phone"  # of the instrument
WINDOWS_PORT = re.compile(r"(\\\\\.\\)?COM\d+", re.IGNORECASE)


def lab_for(source: str, dialect: str = "", baud: int | None = None) -> Lab:
    """Return the lab of a source.

    Parameters
    ----------
    source : str
        LAB.toml; with a dialect, a serial port or a file that grows; else a rig, or a recording that is replayed;
        ``"phone"`` of a phone's sensors over the page.
    dialect : str
        Name of one that is built in, or a file.
    baud : int, optional
        Of a serial port.

    Raises
    ------
    UsageError
        ``no_source`` if nothing of the name is there; ``wrong_value`` if a setting has no effect.
    PlanError
        As `load_lab`.
    """
    path, entry = Path(source), dict[str, object]()
    if baud is not None and not (dialect and _is_port(path)):
        raise UsageError(
            "--baud is of a serial port", do="Leave it out, or name a port and its dialect", code="wrong_value"
        )
    if source == PHONE:
        entry = {"link": "phone"}
    elif dialect:
        if not path.exists() and not WINDOWS_PORT.fullmatch(str(path)):
            raise UsageError(f"{source}: no such port or file", do="Look at its name", code="no_source")
        entry = {"link": "serial" if _is_port(path) else "file", "address": _inside(path), "dialect": dialect}
        entry |= {} if baud is None else {"baud": baud}
    elif path.suffix == ".toml":
        return load_lab(path)
    elif source in RIGS:
        entry = {"link": "rig", "rig": source, "recording": _of_rig(source)}
    elif path.is_file():
        entry = {"link": "replay", "address": _inside(path)}
    else:
        do = "Name a LAB.toml, a recording or a rig; a serial port, or a file that grows, needs a dialect"
        raise UsageError(f"{source}: no such source", do=do, code="no_source")
    name = PHONE if source == PHONE else NAME
    text = toml_text({"schema": 1, "lab": {"title": "guided by hand"}, "instruments": {name: entry}})
    return lab_of(text.encode(), "LAB.toml", Path())


def _inside(path: Path) -> str:
    return os.fspath(path.absolute())


def _is_port(path: Path) -> bool:
    """Tell whether a path is a serial port: a device of characters, or COM of Windows."""
    try:
        return stat.S_ISCHR(path.stat().st_mode)
    except OSError:
        return WINDOWS_PORT.fullmatch(str(path)) is not None


def _of_rig(rig: str) -> str:
    """Return the first recording of a rig in which three accelerometers feel gravity."""
    for path, recording in RIGS.named(rig).twin(1).recordings.items():
        if len(triad(recording)) == 3 and np.isfinite(recording.channels[0].data[:1]).all():
            return Path(path).stem
    raise UsageError(f"rig {rig} has no three accelerometers", do="Take hand_held", code="no_source")
