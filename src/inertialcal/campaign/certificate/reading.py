"""A certificate read back from its XML: figures, units, expanded uncertainties and covariance, to the last digit."""

from __future__ import annotations

import os
import xml.etree.ElementTree as ET  # types only; xml_root reads
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.results import Interval
from ...core.show.frames import frame
from ...core.show.rounding import settled, settled_ends
from ...core.show.tables import Block, Table, html, text
from ...core.unit.d_si import d_si
from ...core.units import multiply
from ...files.source import checked_path, load
from ...files.xml_text import DocumentTypeError, xml_root
from .dcc import DCC, FIGURES, SI, UNITS, VERSION, unit_list
from .signature import signature_of

if TYPE_CHECKING:
    from pandas import DataFrame

CODE = "no_certificate"


@dataclass(frozen=True, eq=False)
class CertifiedFigures:
    """Figures of a model or test.

    Parameters
    ----------
    name, what : str
        As results name it; in words.
    labels, units : tuple of str
        Of each figure.
    values, u : ndarray, shape (n,)
        Figures and their standard uncertainties. [units]
    expanded, k : ndarray, shape (n,), or None
        Expanded uncertainties [units] and coverage factors; None where figures have intervals that are not symmetric.
    intervals : tuple of Interval
        Of 95 %. [units]
    covariance : ndarray, shape (n, n), or None
        [products of units]; None where the certificate does not hold it.
    """

    name: str
    what: str
    labels: tuple[str, ...]
    units: tuple[str, ...]
    values: Array
    u: Array
    expanded: Array | None
    k: Array | None
    intervals: tuple[Interval, ...]
    covariance: Array | None


@dataclass(frozen=True, eq=False)
class ReadCertificate:
    """A certificate that was read.

    Parameters
    ----------
    path, sha256 : str
        The file.
    number, laboratory, issued : str
        Of the certificate.
    item : tuple of str
        Manufacturer, type, serial number.
    figures : tuple of CertifiedFigures
        In the order of the certificate.
    statements : dict of str to str
        What it declares, by name: traceability, conformity, decision rule, deviations.
    signature : {"not signed", "signed, not verified", "verified"}
        Verified with the certificate of the signer that was given.
    """

    path: str
    sha256: str
    number: str
    laboratory: str
    issued: str
    item: tuple[str, str, str]
    figures: tuple[CertifiedFigures, ...]
    statements: dict[str, str]
    signature: str

    def parts(self) -> list[Block]:
        """Return what is shown: a table for each model or test."""
        head = f"certificate {self.number} of {self.laboratory}, issued {self.issued}: {' '.join(self.item)}"
        return [f"{head}; {self.signature}", *(_table(one) for one in self.figures)]

    def to_frame(self) -> DataFrame:
        """Return all figures as a table of pandas."""
        every = [(one, i) for one in self.figures for i in range(len(one.labels))]
        return frame(
            {
                "of": [one.name for one, _ in every],
                "label": [one.labels[i] for one, i in every],
                "value": [float(one.values[i]) for one, i in every],
                "u": [float(one.u[i]) for one, i in every],
                "unit": [one.units[i] for one, i in every],
                "lo": [one.intervals[i].lo for one, i in every],
                "hi": [one.intervals[i].hi for one, i in every],
            }
        )

    def __str__(self) -> str:
        """Return the tables as text."""
        return text(self.parts())

    def _repr_html_(self) -> str:
        """Return the tables for a notebook."""
        return html(self.parts())


def _table(one: CertifiedFigures) -> Table:
    rows = [
        [label, settled(float(one.values[i]), float(one.u[i])),
         settled_ends(float(one.values[i]), float(one.u[i]), one.intervals[i].lo, one.intervals[i].hi), one.units[i]]
        for i, label in enumerate(one.labels)
    ]  # fmt: skip
    return Table(("figure", "value ± u", "95 % interval", "unit"), rows, one.what, right=(1, 2))


def read_certificate(
    path: str | os.PathLike[str], certificate: str | os.PathLike[str] | None = None
) -> ReadCertificate:
    """Return what the XML of a certificate says, as ``inertialcal certificate`` writes it.

    Parameters
    ----------
    path : path
        Of the XML.
    certificate : path, optional
        Certificate of the signer (PEM): the signature is verified.

    Raises
    ------
    DataError
        ``no_certificate``, if it is no such XML, or declares a document type; ``wrong_signature``, if the signature
        does not fit the content and the certificate; ``not_signed``, if a certificate is given and
        nothing is signed.
    UsageError
        ``missing_extra`` where signxml is not installed.
    """
    loaded = load(checked_path(path), document=True)
    where = str(path)
    try:
        root = xml_root(loaded.data)
    except DocumentTypeError as error:
        why = "entities could fill the memory or fetch other files; a certificate has none"
        raise DataError(f"no certificate: {error}", where, why, code=CODE) from None
    except ValueError as error:
        raise DataError(f"no certificate: {error}", where, code=CODE) from None
    if root.tag != f"{{{DCC}}}digitalCalibrationCertificate" or root.get("schemaVersion") != VERSION:
        do = f"Give the XML that inertialcal certificate writes, a DCC {VERSION}"
        raise DataError("no digital calibration certificate of a version that is read", where, do=do, code=CODE)
    signature, read = signature_of(loaded.data, where, certificate)
    try:
        return _read(xml_root(read), where, loaded.sha256, signature)
    except (ValueError, AttributeError, IndexError, DataError) as error:
        said = error.problems[0].what if isinstance(error, DataError) else str(error)
        raise DataError(f"no certificate that was written here: {said}", where, code=CODE) from None


def _read(root: ET.Element, path: str, sha256: str, signature: str) -> ReadCertificate:
    spaces = {"dcc": DCC, "si": SI}

    def said(where: str) -> str:
        found = root.findtext(where, None, spaces)
        if found is None:
            raise ValueError(f"{where} is missing")
        return found

    data = "dcc:administrativeData/"
    item = f"{data}dcc:items/dcc:item/"
    statements = {
        one.findtext("dcc:name/dcc:content", "", spaces): one.findtext("dcc:declaration/dcc:content", "", spaces)
        for one in root.iterfind(f"{data}dcc:statements/dcc:statement", spaces)
    }
    figures = tuple(_figures(one) for one in root.iterfind("dcc:measurementResults/dcc:measurementResult", spaces))
    return ReadCertificate(
        path,
        sha256,
        said(f"{data}dcc:coreData/dcc:uniqueIdentifier"),
        said(f"{data}dcc:calibrationLaboratory/dcc:contact/dcc:name/dcc:content"),
        said(f"{data}dcc:coreData/dcc:issueDate"),
        (
            said(f"{item}dcc:manufacturer/dcc:name/dcc:content"),
            said(f"{item}dcc:model"),
            said(f"{item}dcc:identifications/dcc:identification/dcc:value"),
        ),
        figures,
        statements,
        signature,
    )


def _figures(result: ET.Element) -> CertifiedFigures:
    spaces = {"dcc": DCC, "si": SI}
    quantities = {one.get("refType"): one for one in result.iterfind(".//dcc:data/dcc:quantity", spaces)}
    if not {FIGURES, UNITS} <= set(quantities):
        raise ValueError("a result without figures or units")
    listed = quantities[FIGURES].find("si:realListXMLList", spaces)
    if listed is None:
        raise ValueError("a result without figures")
    units = tuple(quantities[UNITS].findtext("dcc:charsXMLList", "", spaces).split())
    labels = tuple(listed.findtext("si:labelXMLList", "", spaces).split())
    values = _numbers(listed, "si:valueXMLList", len(labels))
    if len(units) != len(labels) or not _has_units(listed, units):
        raise ValueError("two lists of units that differ")
    n = len(labels)
    expanded = k = None
    if (one := listed.find(".//si:expandedMUXMLList", spaces)) is not None:
        expanded, k = _numbers(one, "si:valueExpandedMUXMLList", n), _numbers(one, "si:coverageFactorXMLList", n)
        u, lower, upper = expanded / k, values - expanded, values + expanded
    elif (one := listed.find(".//si:coverageIntervalMUXMLList", spaces)) is not None:
        u = _numbers(one, "si:valueStandardMUXMLList", n)
        lower, upper = _numbers(one, "si:intervalMinXMLList", n), _numbers(one, "si:intervalMaxXMLList", n)
    else:
        raise ValueError("figures without uncertainty")
    p = _numbers(one, "si:coverageProbabilityXMLList", n)
    columns = listed.findall(".//si:columnXMLList/si:covarianceXMLList", spaces)
    covariance = None
    if columns:
        if len(columns) != n:
            raise ValueError(f"covariance of {len(columns)} figures, there are {n}")
        covariance = np.column_stack([_numbers(column, "si:valueXMLList", n) for column in columns])
        for unit, column in zip(units, columns, strict=True):
            if not _has_units(column, [multiply(unit, one) for one in units]):
                raise ValueError("units of the covariance that are not products of those of the figures")
    intervals = tuple(Interval(float(a), float(b), float(c)) for a, b, c in zip(lower, upper, p, strict=True))
    name = quantities[FIGURES].findtext("dcc:name/dcc:content", "", spaces)
    what = result.findtext("dcc:name/dcc:content", "", spaces)
    return CertifiedFigures(name, what, labels, units, values, u, expanded, k, intervals, covariance)


def _has_units(parent: Any, units: Sequence[str]) -> bool:
    """Tell whether a list has these units: one each, or where they are alike one for all."""
    said = parent.findtext("si:unitXMLList", "", {"si": SI}).split()
    return said in (unit_list(units), [d_si(one) for one in units])


def _numbers(parent: Any, name: str, n: int) -> Array:
    found = np.array([float(one) for one in parent.findtext(name, "", {"dcc": DCC, "si": SI}).split()])
    if len(found) != n or not np.isfinite(found).all():
        raise ValueError(f"{name} with {len(found)} numbers, need {n} that are finite")
    return found
