"""Spectrum of a recording at rest without a campaign file: what ``psd FILE`` and ``inertialcal.psd`` do."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ....core.remarks import Remark
from ....core.results import Row
from ....core.show.frames import frame
from ....core.show.result_tables import remarks_line
from ....core.show.rounding import number, with_uncertainty
from ....core.show.tables import Block, Table, html, text
from ....core.units import factor
from ....signals.spectrum.density import Spectrum
from ....signals.spectrum.lines import Line
from ..curves import density_unit
from ..reduction import FILE_UNIT
from .allan import NoiseFile, SensorNoise, allan
from .channels import Said
from .sources import Source

if TYPE_CHECKING:
    from pandas import DataFrame


PER_DECADE = 3  # rows shown
HEADS = ("axis", "line", "frequency", "unit", "amplitude", "unit", "over noise", "kind")


@dataclass(frozen=True)
class Band:
    """Mean density of each axis over a band."""

    frequency: float  # Mean of the band [Hz]
    densities: Mapping[str, float]  # By axis, in ``unit``
    unit: str  # Square of that of the file, a hertz


@dataclass(frozen=True, eq=False)
class SpectrumFile:
    """Spectra of the sensors in a file, with their lines and noise terms."""

    noise: NoiseFile  # All that was found, terms included

    @property
    def sensors(self) -> tuple[SensorNoise, ...]:
        """Gyro, accelerometer, or whatever the file has."""
        return self.noise.sensors

    @property
    def inputs(self) -> Mapping[str, str]:
        """SHA-256 by path."""
        return self.noise.inputs

    @property
    def remarks(self) -> tuple[Remark, ...]:
        """What reading and reducing brought up."""
        return self.noise.remarks

    @property
    def rows(self) -> tuple[Row, ...]:
        """Lines first, then terms."""
        rows = self.noise.rows
        lines = [row for row in rows if row.key.at is not None]
        return (*lines, *(row for row in rows if row not in lines))

    def content(self) -> dict[str, Any]:
        """Return figures and spectra as ``results.json`` would hold them."""
        spectra = [one for one in self.noise.content()["curves"] if one["name"] == "spectrum"]
        return {"results": [row.to_dict() for row in self.rows], "curves": spectra}

    def bands(self, sensor: SensorNoise, per_decade: int = PER_DECADE) -> tuple[Band, ...]:
        """Return mean densities over bands of equal width on a logarithmic axis.

        Parameters
        ----------
        sensor : SensorNoise
            Which.
        per_decade : int
            Bands in a decade.
        """
        unit, scale = _density(sensor)
        found: dict[float, dict[str, float]] = {}
        for axis, spectrum in _spectra(sensor):
            frequency, density, _ = spectrum.smoothed(per_decade)
            for f, value in zip(frequency.tolist(), (density[:, 0] * scale).tolist(), strict=True):
                found.setdefault(f, {})[axis] = value
        return tuple(Band(f, values, unit) for f, values in sorted(found.items()))

    def agreement(self, sensor: SensorNoise) -> Iterator[str]:
        """Yield for each axis whether its Allan deviation agrees with its spectrum.

        Parameters
        ----------
        sensor : SensorNoise
            Which.
        """
        for one in sensor.result.axes:
            for record in one.records:
                found = record.spectral.agreement
                if found is None or not found.compared:
                    yield f"{one.axis}: Allan deviation and spectrum could not be compared"
                    continue
                word = "agree" if found.agree.all() else "DISAGREE"
                yield f"{one.axis}: Allan deviation and spectrum {word} at {found.compared} averaging times"

    def to_frame(self) -> DataFrame:
        """Return a pandas DataFrame: a row a frequency of an axis, with density, interval and terms."""
        columns: dict[str, list[Any]] = {"sensor": [], "axis": []}
        for sensor in self.sensors:
            for curve in sensor.curves():
                if curve.name == "spectrum":
                    count = len(curve.columns["frequency"].values)
                    columns["sensor"] += [sensor.name] * count
                    columns["axis"] += [curve.axis] * count
                    for name in ("frequency", "density", "lo", "hi"):
                        columns.setdefault(name, []).extend(curve.columns[name].plain())
        return frame(columns)

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: bands and lines of each sensor, the check against the Allan deviation."""
        shown: list[Block] = []
        for sensor in self.sensors:
            shown += [*self.tables(sensor), *self.agreement(sensor)]
        return (*shown, *remarks_line(self.remarks))

    def tables(self, sensor: SensorNoise) -> list[Table]:
        """Return the bands of a sensor, and its lines where it has any.

        Parameters
        ----------
        sensor : SensorNoise
            Which.
        """
        bands = self.bands(sensor)
        axes = list(dict.fromkeys(axis for band in bands for axis in band.densities))
        unit = bands[0].unit if bands else ""
        rows = [
            (number(band.frequency, 4), *(number(band.densities.get(axis), 4) for axis in axes)) for band in bands
        ]  # fmt: skip
        found = [Table(("f [Hz]", *axes), rows, f"{_caption(sensor)}; means over bands [{unit}]", range(len(axes) + 1))]
        lines = [cells for one in sensor.result.axes for record in one.records for cells in _lines(sensor, one.axis,
                 record.spectral.lines.found if record.spectral.lines else ())]  # fmt: skip
        return [*found, Table(HEADS, lines, "lines", (2, 4, 6))] if lines else found

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html(self.parts())


def _spectra(sensor: SensorNoise) -> Iterator[tuple[str, Spectrum]]:
    for one in sensor.result.axes:
        for record in one.records:
            if record.spectral.spectrum is not None:
                yield one.axis, record.spectral.spectrum


def _caption(sensor: SensorNoise) -> str:
    first = next((spectrum for _, spectrum in _spectra(sensor)), None)
    if first is None:
        return f"{sensor.name}: no spectrum"
    length = number(first.segment * first.interval, 4)
    return (
        f"{sensor.name}: spectrum ({first.method}), {first.segments} segment(s) of {length} s,"
        f" {number(first.edf, 3)} degrees of freedom a value"
    )


def _density(sensor: SensorNoise) -> tuple[str, float]:
    """Return the unit that densities are shown in, and the factor from that inside."""
    if sensor.group.kind is None:
        return density_unit(sensor.group.unit or FILE_UNIT), 1.0
    inside = {"gyro": "rad/s", "accelerometer": "m/s^2"}[sensor.group.kind]
    return density_unit(sensor.group.unit), factor(inside, sensor.group.unit) ** 2


def _lines(sensor: SensorNoise, axis: str, found: Sequence[Line]) -> Iterator[tuple[str, ...]]:
    shown, scale = sensor.group.unit or FILE_UNIT, _density(sensor)[1] ** 0.5
    for line in found:
        frequency = with_uncertainty(line.frequency, line.u_frequency)
        amplitude = with_uncertainty(line.amplitude * scale, line.u_amplitude * scale)
        yield (axis, line.name, frequency, "Hz", amplitude, shown, number(line.ratio, 3), line.kind)


def psd(
    source: Source,
    *,
    method: str = "welch",
    segment: str | None = None,
    columns: Sequence[str] = (),
    quantity: Said | None = None,
    scale_factors: Mapping[str, str] | None = None,
    terms: Sequence[str] | None = None,
    warm_up: str = "0 s",
    keep_disturbed: bool = False,
    **recorded: Any,
) -> SpectrumFile:
    """Return the spectrum of a sensor at rest, its lines, and the noise terms drawn into it.

    Parameters
    ----------
    source : path, Recording or array
        As ``inertialcal.allan`` takes it.
    method : {"welch", "multitaper"}
        How it is estimated.
    segment : str, optional
        Length of its segments; an eighth of the record by default, with several tapers as long as is fast.
    columns, quantity, scale_factors, terms, warm_up, keep_disturbed, **recorded
        As ``inertialcal.allan`` takes them.

    Raises
    ------
    DataError, UsageError
        As ``inertialcal.allan``.
    """
    found = allan(
        source, columns=columns, quantity=quantity, scale_factors=scale_factors, terms=terms, warm_up=warm_up,
        keep_disturbed=keep_disturbed, spectrum=method, segment=segment, **recorded,
    )  # fmt: skip
    return SpectrumFile(found)


__all__ = ["Band", "SpectrumFile", "psd"]
