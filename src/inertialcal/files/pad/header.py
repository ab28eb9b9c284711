"""Header of an archive file: start, sample rate, layout of the bytes, coordinate systems, what was applied."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET  # types only; read_xml reads
from dataclasses import dataclass
from pathlib import Path

from ...core.estimate import Array
from ...core.times import read_instant
from ...physics.attitude import from_roll_pitch_yaw
from .xml import bad_header, read_xml

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
    """Attitude of a coordinate system in that of the station.

    Parameters
    ----------
    name : str
        ``"121f03"``, ``"SSAnalysis"``.
    roll, pitch, yaw : float
        As the header has them [deg].
    """

    name: str
    roll: float
    pitch: float
    yaw: float

    @property
    def C_station_system(self) -> Array:
        """Matrix that takes components in this system to those of the station, shape (3, 3)."""
        return from_roll_pitch_yaw(*(math.radians(angle) for angle in (self.roll, self.pitch, self.yaw)))

    def __str__(self) -> str:
        """Name and angles."""
        return f"{self.name} (roll {self.roll:g}, pitch {self.pitch:g}, yaw {self.yaw:g} deg)"


@dataclass(frozen=True)
class PadHeader:
    """What a header says.

    Parameters
    ----------
    system : str
        Name of its root: ``"sams2_accel"``, ``"mams_accel_ossraw"``.
    sensor : str
        SensorID.
    time_zero : int
        Instant of t = 0 [ns since 1970 UTC].
    sample_rate : float
        [Hz].
    number_type : str
        ``"<f4"``, ``">f4"``, or ``""`` for text.
    data_file : str
        Name that GData gives to the data file; empty where it gives none.
    gain, cutoff : float or None
        Gain of the chain, and cutoff of its filter [Hz], where they are said.
    bias, scale_factor : tuple of float, or None
        BiasCoeff and ScaleFactor of x, y, z, where they are said.
    sensor_system, data_system : CoordinateSystem or None
        Of the head's axes, and of the axes that the data are given in.
    quality, configuration : str
        DataQualityMeasure (what was applied) and ISSConfiguration.
    """

    system: str
    sensor: str
    time_zero: int
    sample_rate: float
    number_type: str
    data_file: str
    gain: float | None
    cutoff: float | None
    bias: tuple[float, ...] | None
    scale_factor: tuple[float, ...] | None
    sensor_system: CoordinateSystem | None
    data_system: CoordinateSystem | None
    quality: str
    configuration: str


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
    number_type, data_file = _layout(root, where)
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
        raise bad_header(where, f"{what} {text!r} is no number")
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


def _layout(root: ET.Element, where: str) -> tuple[str, str]:
    """Type of a number, and the name of the data file."""
    found = root.find("GData")
    if found is None:
        raise bad_header(where, "the header has no GData, which says how the bytes of the data are laid out")
    said = found.get("format", "")
    known = FORMATS.get(" ".join(said.lower().split()))
    if known is None:
        raise bad_header(where, f"GData format {said!r} is none of: {', '.join(FORMATS)}")
    return known, found.get("file", "")
