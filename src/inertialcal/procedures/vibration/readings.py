"""A run as samples on the grid of their interval: control channels, responses, the profile that it was run to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, cast

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.key import AXES
from ...core.recording import Recording
from ...core.remarks import Remark
from ...signals.allan import on_grid
from ...signals.vibration.profile import Profile
from ..protocol import Source
from ..static_noise.readings import AtRest
from ..static_noise.recordings import grid_of
from .plan import CONTROLS, Plan
from .profile_file import StatedProfile, read_profile, stated

if TYPE_CHECKING:
    from .entry import VibrationEntry


@dataclass(frozen=True, eq=False)
class Readings:
    """One run.

    Parameters
    ----------
    name, where : str
        Of the recording; its file.
    interval : float
        From sample to sample [s].
    control : ndarray, shape (n, c)
        Control channels; NaN where a sample is missing [m/s^2].
    controls : tuple of str
        Their names: columns of the file.
    responses : ndarray, shape (n, r)
        Axes of the sensor that are no control [SI].
    axes : tuple of str
        Of the responses.
    unit : str
        Of the responses, SI.
    own : bool
        The sensor itself is the first control channel.
    profile : StatedProfile
        That the run was made to.
    cut_off : float or None
        Of the sensor's low pass, where that is known [Hz].
    remarks : tuple of Remark
        What reading brought up.
    """

    name: str
    where: str
    interval: float
    control: Array
    controls: tuple[str, ...]
    responses: Array
    axes: tuple[str, ...]
    unit: str
    own: bool
    profile: StatedProfile
    cut_off: float | None = None
    remarks: tuple[Remark, ...] = ()

    def __len__(self) -> int:
        return len(self.control)


def readings_from(plan: Plan, sources: Sequence[Source]) -> Readings:
    """Return the run of a test.

    Raises
    ------
    DataError
        ``several_runs`` for more than one recording, or a window each; ``no_profile``; ``no_control``; as the grid of
        a record at rest and as ``profile_file`` refuse.
    """
    parts = [(source, one) for source in sources for _, one in source.recordings()]
    if len(parts) != 1:
        what = f"{len(parts)} recordings of a run: {', '.join(source.name for source, _ in parts)}"
        do = "Give each run a test of its own"
        raise DataError(what, sources[0].file, "levels and durations are of one run", do, "several_runs")
    source, recording = parts[0]
    entry = cast("VibrationEntry", source.entry)
    if entry.profile is None:
        do = 'Say profile = "FILE.csv" in the entry of the recording'
        raise DataError(f"recordings.{source.name}: no profile", source.file, "a run is judged against one", do,
                        "no_profile")  # fmt: skip
    found = cast("StatedProfile | Profile", source.read_file(entry.profile, read_profile))
    profile = found if isinstance(found, StatedProfile) else stated(found)  # a rig has the profile itself
    axes = tuple(axis for axis in AXES if axis in recording.names)
    controls = [name for name in CONTROLS if name in recording.names]
    own = CONTROLS[0] not in controls
    if own:
        if source.facts.kind != "accelerometer" or (entry.axis not in axes and len(axes) != 1):
            what = f"recordings.{source.name}: no channel control"
            do = "Name the column of the control accelerometer: channels.control, or the excited axis of the sensor:"
            raise DataError(what, source.file, "nothing says what the table was controlled by", f'{do} axis = "x"',
                            "no_control")  # fmt: skip
        first = entry.axis if entry.axis in axes else axes[0]
        controls = [str(first), *controls]
        axes = tuple(axis for axis in axes if axis != first)
    names = [*controls, *axes]
    values, interval, remarks = _on_grid(recording, names, source.name)
    channels = entry.channels or {}
    called = [str(channels[name].column) if name in channels else name for name in controls]
    c = len(controls)
    return Readings(
        source.name, source.file, interval, values[:, :c], tuple(called), values[:, c:], axes, source.facts.si, own,
        profile, source.facts.cut_off or recording.cut_off, (*recording.remarks, *remarks, *profile.remarks),
    )  # fmt: skip


def _on_grid(recording: Recording, names: Sequence[str], label: str) -> tuple[Array, float, tuple[Remark, ...]]:
    """Return channels, shape (n, c), on the grid of the sample interval; NaN where no sample came."""
    if recording.sample_interval is None:
        do = "Add the sample rate (--sample-rate HZ) or the time column (--time-column)"
        raise DataError("sample interval not known", label, "a spectrum needs it", do, "no_time")
    grid = grid_of(AtRest(recording, dict(zip(names, names, strict=True)), "rate", label))
    values = recording.array(names)
    if not grid.placed or recording.time_ns is None:
        return values, grid.interval, grid.remarks
    placed, present = on_grid(values, recording.time_ns, grid.interval)
    found = np.asarray(placed, dtype=np.float64)
    found[~present] = np.nan
    return found, grid.interval, grid.remarks


__all__ = ["Readings", "readings_from"]
