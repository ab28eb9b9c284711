"""Header of an archive file: start, sample rate, layout of the bytes, coordinate systems, what was applied; its stamps.

Stamps are made anew as time zero + n / sample rate. The file's time is 32 bits wide: 600 s into a file it moves in
steps of 61 us, a day into it in steps of 7.8 ms, which is more than a sample interval. So the file's own stamps only
tell whether they go forward in steps of the header's sample rate, where samples are missing (the count then starts
anew behind the gap), and whether they run away from the count.
"""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ET  # types only; xml_root reads
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...core.batches import batches, empty, every, extremes, is_stored, put, thinned, where_steps
from ...core.errors import DataError
from ...core.estimate import Array, Numbers
from ...core.recording import SECOND, Times
from ...core.remarks import Remark
from ...core.times import instant_text, read_instant
from ...physics.attitude import from_roll_pitch_yaw
from ..source import read_bytes
from ..xml_text import DocumentTypeError, xml_root

FORMATS = {  # as the archive writes them -> type of a number; "" is text
    "binary 32 bit ieee float little endian": "<f4",
    "binary 32 bit ieee float big endian": ">f4",
    "ascii": "",
}
SLOWEST, FASTEST = 1e-4, 1e6  # [Hz]; beyond these the number is damaged
VECTOR = ("x", "y", "z")
ANGLES = ("r", "p", "w")


@dataclass(frozen=True)
class CoordinateSystem:
    """Attitude of a coordinate system in that of the station."""

    name: str  # ``"121f03"``, ``"SSAnalysis"``
    roll: float  # As the header has them [deg]
    pitch: float  # As the header has them [deg]
    yaw: float  # As the header has them [deg]

    @property
    def C_station_system(self) -> Array:
        """Matrix that takes components in this system to those of the station, shape (3, 3)."""
        return from_roll_pitch_yaw(*(math.radians(angle) for angle in (self.roll, self.pitch, self.yaw)))

    def __str__(self) -> str:
        """Name and angles."""
        return f"{self.name} (roll {self.roll:g}, pitch {self.pitch:g}, yaw {self.yaw:g} deg)"


@dataclass(frozen=True)
class PadHeader:
    """What a header says."""

    system: str  # Name of its root: ``"sams2_accel"``, ``"mams_accel_ossraw"``
    sensor: str  # SensorID
    time_zero: int  # Instant of t = 0 [ns since 1970 UTC]
    sample_rate: float  # [Hz]
    number_type: str  # ``"<f4"``, ``">f4"``, or ``""`` for text
    data_file: str  # Name that GData gives to the data file; empty where it gives none
    gain: float | None  # Of the chain, where the header says it
    cutoff: float | None  # Of its filter [Hz], where the header says it
    bias: tuple[float, ...] | None  # BiasCoeff of x, y, z, where the header says it
    scale_factor: tuple[float, ...] | None  # ScaleFactor of x, y, z, where the header says it
    sensor_system: CoordinateSystem | None  # Of the head's axes
    data_system: CoordinateSystem | None  # Of the axes that the data are given in
    quality: str  # DataQualityMeasure: what was applied
    configuration: str  # ISSConfiguration


def read_header(path: Path) -> PadHeader:
    """Return what a header says.

    Raises
    ------
    DataError
        ``bad_header``, if it is no XML, too large, has a document type, lacks one of SensorID, TimeZero, SampleRate
        and GData, or if a value in it is none of its kind.
    """
    root, where = read_xml(path), str(path)
    rate = _number(root, "SampleRate", where)
    if rate is None or not SLOWEST <= rate <= FASTEST:
        need = f"need one above zero, from {SLOWEST:g} to {FASTEST:g} Hz"
        raise bad_header(where, f"SampleRate {_text(root, 'SampleRate', where)!r}: {need}")
    # Type of a number, and the name of the data file
    found = root.find("GData")
    if found is None:
        raise bad_header(where, "the header has no GData, which gives the layout of the data")
    said = found.get("format", "")
    known = FORMATS.get(" ".join(said.lower().split()))
    if known is None:
        raise bad_header(where, f"GData format {said!r} is none of: {', '.join(FORMATS)}")
    number_type, data_file = known, found.get("file", "")
    return PadHeader(
        system=root.tag,
        sensor=_text(root, "SensorID", where),
        time_zero=_time_zero(root, where),
        sample_rate=rate,
        number_type=number_type,
        data_file=data_file,
        gain=_number(root, "Gain", where),
        cutoff=_number(root, "CutoffFreq", where),
        bias=_vector(root, "BiasCoeff", where),
        scale_factor=_vector(root, "ScaleFactor", where),
        sensor_system=_system(root, "SensorCoordinateSystem", where),
        data_system=_system(root, "DataCoordinateSystem", where),
        quality=_said(root, "DataQualityMeasure"),
        configuration=_said(root, "ISSConfiguration"),
    )


def _said(root: ET.Element, name: str) -> str:
    return " ".join((root.findtext(name) or "").split())


def _text(root: ET.Element, name: str, where: str) -> str:
    """Text that must be there."""
    found = _said(root, name)
    if not found:
        raise bad_header(where, f"the header has no {name}")
    return found


def _float(text: str, what: str, where: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise bad_header(where, f"{what} {text!r} is not a number")
    return value


def _number(root: ET.Element, name: str, where: str) -> float | None:
    text = _said(root, name)
    return _float(text, name, where) if text else None


def _attributes(root: ET.Element, name: str, keys: tuple[str, ...], where: str) -> tuple[float, ...] | None:
    found = root.find(name)
    if found is None:
        return None
    return tuple(_float(found.get(key, ""), f"{name} {key}", where) for key in keys)


def _vector(root: ET.Element, name: str, where: str) -> tuple[float, ...] | None:
    return _attributes(root, name, VECTOR, where)


def _system(root: ET.Element, name: str, where: str) -> CoordinateSystem | None:
    angles = _attributes(root, name, ANGLES, where)
    found = root.find(name)
    if angles is None or found is None:
        return None
    return CoordinateSystem(found.get("name", "") or name, *angles)


def _time_zero(root: ET.Element, where: str) -> int:
    text = _text(root, "TimeZero", where)
    try:
        return read_instant(text)
    except ValueError as error:
        raise bad_header(where, f"TimeZero: {error}") from None


LARGEST = 2**16  # bytes; headers of the archive have 700 to 1500


def read_xml(path: Path) -> ET.Element:
    """Return the root of a header.

    Raises
    ------
    DataError
        ``bad_header``, if it is larger than 64 KiB, no XML, or declares a document type or an entity;
        ``missing_file``, if it cannot be read.
    """
    where = str(path)
    data = read_bytes(path, LARGEST + 1)
    if len(data) > LARGEST:
        raise bad_header(where, f"the header has more than {LARGEST} bytes; headers of the archive have about 1000")
    try:
        return xml_root(data)
    except DocumentTypeError:
        raise DataError(
            "the header declares a document type",
            where=where,
            why="entities could fill the memory or fetch other files; headers of the archive have none",
            do="Fetch it again from the archive",
            code="bad_header",
        ) from None
    except ValueError as error:
        raise bad_header(where, f"the header is {error}") from None


def bad_header(where: str, what: str) -> DataError:
    """Return the error for a header that cannot be used."""
    return DataError(what, where=where, do="Fetch it again from the archive", code="bad_header")


BLOCK = 2**18  # stamps
STEPS = ("bias", "scale_factor", "misalignment")
MEANINGS = (
    (re.compile(r"temperature"), ("bias", "scale_factor")),
    (re.compile(r"gain"), ("scale_factor",)),
    (re.compile(r"mis-?\s?alignment"), ("misalignment",)),
)
NOT = re.compile(r"\b(no|not|without)\b[^,;]*|[^,;]*\bun(compensat|correct|calibrat|appli)[^,;]*")


def applied(header: PadHeader) -> tuple[str, ...]:
    """Return the steps that a header says were made; what follows "no", or is called uncorrected, was not."""
    said = NOT.sub("", header.quality.lower())
    found = {step for word, steps in MEANINGS if word.search(said) for step in steps}
    return tuple(step for step in STEPS if step in found)


PLACEHOLDER = (1.23, 4.46, 7.89)  # BiasCoeff of several heads in the archive, digits in a row
LONGER = 1.5  # step, in intervals, from which samples are missing


def header_remarks(header: PadHeader, where: str) -> tuple[Remark, ...]:
    """Return what the header says was done to the data, and the bias that it gives and that was not applied."""
    said = [f"DataQualityMeasure {header.quality!r}"] if header.quality else []
    said += [f"{name} {value:g}" for name, value in (("Gain", header.gain),) if value is not None]
    said += [f"CutoffFreq {header.cutoff:g} Hz"] if header.cutoff is not None else []
    said += [f"ScaleFactor {_triple(header.scale_factor)}"] if header.scale_factor else []
    remarks = []
    if said:
        do = "These steps are not applied again"
        remarks.append(Remark("as_archived", "info", f"the header says: {', '.join(said)}", where, do=do))
    if header.bias is not None and any(header.bias):
        digits = " (placeholder digits, which several heads have)" if header.bias == PLACEHOLDER else ""
        what = f"BiasCoeff {_triple(header.bias)}{digits} in the header was not applied"
        remarks.append(Remark("bias_not_applied", "warning" if digits else "info", what, where))
    return tuple(remarks)


def time_remarks(stamps: Stamps, sample_rate: float, where: str) -> tuple[Remark, ...]:
    """Return how the stamps were made, and whether the file's own run away from them."""
    n = len(stamps.time_ns)
    if stamps.drifts:
        off = 1e6 * (stamps.interval * sample_rate - 1.0)
        what = (
            f"the file's own time drifts from TimeZero + n/({sample_rate:.9g} Hz) by up to "
            f"{stamps.deviation:.4g} s ({off:+.3g} ppm): its time stamps say {1.0 / stamps.interval:.9g} Hz"
        )
        do = f"If the stamps are right: --sample-rate {1.0 / stamps.interval:.9g}"
        return (Remark("stamps_drift", "warning", what, where, do=do),)
    what = (
        f"time stamps computed as TimeZero + n/({sample_rate:.9g} Hz); the file's own 32-bit time agrees within "
        f"{1e6 * stamps.deviation:.3g} us over {n} samples"
    )
    return (Remark("stamps_made", "info", what, where),)


def gap_remark(time_ns: Times, sample_rate: float, path: str) -> tuple[Remark, ...]:
    """Return one remark on the gaps inside and between the files."""
    interval = SECOND / sample_rate
    at = where_steps(time_ns, lambda step: step > LONGER * interval) - 1
    if not len(at):
        return ()
    steps = (time_ns[at + 1] - time_ns[at]).astype(np.float64)
    missing = int(np.rint(steps / interval).sum()) - len(at)
    what = (
        f"gap: {missing} sample(s) missing in all, longest step {steps.max() / SECOND:.6g} s against "
        f"{1e3 / sample_rate:.4g} ms; the first after {instant_text(int(time_ns[at[0]]))}"
    )
    return (Remark("gaps", "warning", what, path, count=len(at)),)


def change_remarks(headers: Sequence[PadHeader], names: Sequence[str]) -> tuple[Remark, ...]:
    """Return what changes from file to file: gain, filter, what was applied."""
    remarks = []
    for code, what, said in (
        ("gain_changed", "Gain", [header.gain for header in headers]),
        ("filter_changed", "CutoffFreq", [header.cutoff for header in headers]),
        ("scale_factor_changed", "ScaleFactor", [header.scale_factor for header in headers]),
        ("quality_changed", "DataQualityMeasure", [header.quality for header in headers]),
    ):
        changes = [i for i in range(1, len(said)) if said[i] != said[i - 1]]
        if changes:
            first = changes[0]
            text = f"{what} changes between files, from {said[first - 1]} to {said[first]}"
            do = "Use one part alone (--from, --to)"
            remarks.append(Remark(code, "warning", text, names[first], count=len(changes), do=do))
    return tuple(remarks)


def _triple(values: Sequence[float] | None) -> str:
    return " ".join(f"{axis}={value:g}" for axis, value in zip("xyz", values or (), strict=False))


STRETCHES = 1000  # over which the median step is taken
RATES_AGREE = 0.01  # relative difference of the two sample rates, as for any other file
LONGEST = 6.3e9  # time of a record: 200 years, which int64 holds in nanoseconds [s]
JUMP = 0.5  # in intervals, from which a step is no jitter
DRIFT = 0.05  # in intervals, from which stamps run away from the count


@dataclass(frozen=True, eq=False)
class Stamps:
    """Time axis of one file."""

    time_ns: Times  # shape (n,): regenerated [ns since 1970 UTC]
    end: int  # Last of the file's own stamps [ns since 1970 UTC]
    interval: float  # By the file's own stamps, over the longest run without a gap [s]
    uncertain: float  # By how much it may be wrong for the width of the stamps [s]
    deviation: float  # Largest difference of the file's stamps from the regenerated ones [s]
    resolution: float  # Step in which the file's time moves at its end [s]
    drifts: bool  # Whether that is more than its resolution and a twentieth of an interval explain
    jumps: NDArray[np.int64]  # shape (k,): index of the last sample before each gap inside the file


def regenerate(time: Numbers, zero: int, sample_rate: float, where: str) -> Stamps:
    """Return the stamps of a file.

    Parameters
    ----------
    time : ndarray, shape (n,)
        As the file has it [s since ``zero``].
    zero : int
        Time zero of the header [ns since 1970 UTC].
    sample_rate : float
        [Hz].
    where : str
        File, for messages.

    Raises
    ------
    DataError
        ``bad_stamps``, if a stamp is no number, earlier than the one before it, or centuries away.
    """
    if not every(time, lambda part: np.isfinite(part).all()):
        first = int(np.argmin(np.isfinite(time)))
        raise bad_stamps(f"record {first + 1}: the time is not a number", where)
    farthest = max(map(abs, extremes(time)))
    if farthest > LONGEST:
        first = int(np.argmax(np.abs(time)))
        raise bad_stamps(f"record {first + 1}: {time[first]:.3g} s, more than 200 years from the header's time", where)
    resolution = float(np.spacing(np.float32(farthest)))
    jumps = _jumps(time, median_step(time) if len(time) > 1 else 1.0 / sample_rate, resolution, where)
    interval, uncertain = _longest_run(time, jumps, resolution) if len(time) > 1 else (1.0 / sample_rate, 0.0)
    time_ns = empty(len(time), np.int64, is_stored(time) or None)
    deviation = 0.0
    for first, last in _runs(len(time), jumps):
        begin, own = float(time[first]), time[first:last]
        for a, b in batches(own, size=BLOCK):
            since: Array = begin + np.arange(a, b) / sample_rate
            put(time_ns, first + a, zero + np.rint(since * SECOND).astype(np.int64))
            deviation = max(deviation, float(np.abs(own[a:b] - since).max()))
    drifts = deviation > resolution + DRIFT / sample_rate
    end = zero + round(float(time[-1]) * SECOND)
    return Stamps(time_ns, end, interval, uncertain, deviation, resolution, drifts, jumps)


def median_step(time: Numbers) -> float:
    """Return the median over stretches of their mean step [s]: neither gaps nor the width of the floats move it."""
    size = max(1, (len(time) - 1) // STRETCHES)
    ends = thinned(time, size).astype(np.float64)
    return float(np.median(np.diff(ends))) / size


def rates_agree(stamps: Stamps, sample_rate: float) -> bool:
    """Whether the file's own stamps go as fast as the sample rate [Hz], within a hundredth."""
    return abs(stamps.interval - 1.0 / sample_rate) <= RATES_AGREE / sample_rate + stamps.uncertain


def _runs(n: int, jumps: NDArray[np.int64]) -> Iterator[tuple[int, int]]:
    """Begin and end of each run of samples without a gap."""
    ends = [*(int(jump) + 1 for jump in jumps), n]
    yield from zip([0, *ends[:-1]], ends, strict=True)


def _longest_run(time: Numbers, jumps: NDArray[np.int64], resolution: float) -> tuple[float, float]:
    """Mean step over the longest run without a gap, and how far the width of the stamps may move it [s]."""
    first, last = max(_runs(len(time), jumps), key=lambda run: run[1] - run[0])
    steps = last - first - 1
    if not steps:
        return median_step(time), resolution
    return (float(time[last - 1]) - float(time[first])) / steps, resolution / steps


def _jumps(time: Numbers, interval: float, resolution: float, where: str) -> NDArray[np.int64]:
    """Index of the last sample before each step that is longer than jitter and resolution explain."""
    found = []
    for first, stop in batches(time[:-1], size=BLOCK):
        steps = np.diff(time[first : stop + 1].astype(np.float64))
        back = np.flatnonzero(steps < -resolution)
        if len(back):
            what = f"record {first + int(back[0]) + 2}: the time is earlier than in the previous record"
            raise bad_stamps(what, where)
        found.append(first + np.flatnonzero(steps - interval > JUMP * max(interval, 0.0) + resolution))
    return np.concatenate(found).astype(np.int64) if found else np.empty(0, dtype=np.int64)


def bad_stamps(what: str, where: str) -> DataError:
    """Return the error for stamps that are no time."""
    return DataError(what, where=where, do="Fetch both files of the pair again from the archive", code="bad_stamps")
