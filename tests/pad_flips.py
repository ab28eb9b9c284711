"""Archive records of a head that is turned: a rig's flip in files of the archive, one after the other."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from inertialcal.rigs.sams_tsh.campaign import FILE
from inertialcal.rigs.sams_tsh.rig import Bench, build
from pad_pairs_made import START, header, pair, stamp, systems

BENCH = replace(Bench(), rate=5.0, duration=1800.0, turn_starts=(600.0, 1200.0), window=200.0, saved="g", said="g")
TURNED = (0.0, 0.0, 90.0)  # attitude of the sensor: its axes are not those of the data


def records(folder: Path, files: int = 3, sensor: str = "121f03", bench: Bench = BENCH, seed: int = 4) -> Path:
    """Write the record of a flip as pairs of the archive; return their folder."""
    folder.mkdir(parents=True, exist_ok=True)
    readings = build(bench, seed).recordings[FILE].array("xyz")
    for i, part in enumerate(np.array_split(readings, files)):
        table = np.column_stack([np.arange(len(part)) / bench.rate, part]).astype(np.float32)
        start = stamp(START, sum(len(one) for one in np.array_split(readings, files)[:i]) / bench.rate)
        text = header(start, sensor, rate=f"{bench.rate:g}", more=f"<Gain>10.0</Gain>{systems(TURNED)}")
        pair(folder, table, start=start, sign="+" if i else "-", sensor=sensor, text=text)
    return folder
