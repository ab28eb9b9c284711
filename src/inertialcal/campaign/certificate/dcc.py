"""A certificate as XML: Digital Calibration Certificate (DCC) 3.3.0, Digital System of Units (D-SI) 2.2.1.

Figures of a model or test are one list: labels, values, units, 95 % intervals, and their covariance as an ellipsoid of
95 %. Numbers have all their digits. The units of the results stand beside, as a list of their own: the D-SI has no
counts.

References
----------
.. [1] Physikalisch-Technische Bundesanstalt, Digital Calibration Certificate, schema 3.3.0 (ptb.de/dcc).
.. [2] ILAC-G8:09/2019, 4.2.3: Conditional Pass and Conditional Fail, where a guard band is not met.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from decimal import Decimal
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np

from ...core.unit.d_si import d_si
from ...core.units import multiply
from ...statistics.quantiles import chi_square_quantile
from ..file.certificate import Address
from .content import Content, Figures, P
from .words import (
    EQUATION,
    NOT_TRACEABLE,
    ONLY_THESE,
    REFUTED,
    REPRODUCTION,
    SIMULATED,
    UNCERTAINTY,
    rules_text,
    standard_text,
    verdict_text,
)

DCC, SI = "https://ptb.de/dcc", "https://ptb.de/si"
VERSION = "3.3.0"
SOFTWARE = "inertialcal"
PLACES = {"laboratory_branch": "laboratoryBranch", "customer_branch": "customerBranch"}
CONFORMITY = {"PASS": "pass", "FAIL": "fail"}
FIGURES, UNITS, MATRIX = "inertialcal_figures", "inertialcal_units", "inertialcal_matrix"
RELEASE = re.compile(r"[0-9]{1,3}(\.[0-9]{1,3}){0,3}")
ET.register_namespace("dcc", DCC)
ET.register_namespace("si", SI)


def dcc_xml(content: Content) -> bytes:
    """Return a certificate as a Digital Calibration Certificate, UTF-8.

    Raises
    ------
    DataError
        ``not_in_d_si`` for a unit that the D-SI cannot say.
    """
    root = ET.Element(f"{{{DCC}}}digitalCalibrationCertificate", {"schemaVersion": VERSION})
    _administrative(_in(root, "administrativeData"), content)
    results = _in(root, "measurementResults")
    for number, figures in enumerate(content.figures):
        _result(_in(results, "measurementResult"), content, figures, first=not number)
    ET.indent(root)
    text: bytes = ET.tostring(root, encoding="utf-8")
    return b'<?xml version="1.0" encoding="UTF-8"?>\n' + text + b"\n"


def _in(parent: ET.Element, name: str, value: str | None = None, namespace: str = DCC) -> ET.Element:
    made = ET.SubElement(parent, f"{{{namespace}}}{name}")
    made.text = value
    return made


def _text(parent: ET.Element, name: str, *said: str) -> ET.Element:
    """Add an element of text: a ``content`` for each part."""
    made = _in(parent, name)
    for one in said:
        _in(made, "content", one).set("lang", "en")
    return made


def _rich(parent: ET.Element, name: str, said: str) -> ET.Element:
    return _text(parent, name, said)


# Administrative data


def _administrative(parent: ET.Element, content: Content) -> None:
    stated = content.stated
    _software(_in(parent, "dccSoftware"), content)
    core = _in(parent, "coreData")
    _in(core, "countryCodeISO3166_1", stated.laboratory.country)
    _in(core, "usedLangCodeISO639_1", "en")
    _in(core, "mandatoryLangCodeISO639_1", "en")
    _in(core, "uniqueIdentifier", stated.number)
    if stated.received is not None:
        _in(core, "receiptDate", stated.received.isoformat())
    performed = stated.performed or []
    _in(core, "beginPerformanceDate", performed[0].isoformat())
    _in(core, "endPerformanceDate", performed[-1].isoformat())
    _in(core, "performanceLocation", PLACES.get(stated.place, stated.place))
    if stated.issued is not None:
        _in(core, "issueDate", stated.issued.isoformat())
    if stated.replaces:
        change = _in(core, "reportAmendedSubstituted")
        _in(change, "typeOfChange", "substituted")
        _in(change, "replacedUniqueIdentifier", stated.replaces)
    _item(_in(_in(parent, "items"), "item"), content)
    _contact(_in(_in(parent, "calibrationLaboratory"), "contact"), stated.laboratory)
    people = _in(parent, "respPersons")
    for number, person in enumerate(stated.signatures):
        one = _in(people, "respPerson")
        _text(_in(one, "person"), "name", person.name)
        _in(one, "role", person.function)
        _in(one, "mainSigner", "true" if not number else "false")
    _contact(_in(parent, "customer"), stated.customer)
    statements = _in(parent, "statements")
    for name, said in _statements(content):
        statement = _in(statements, "statement")
        _text(statement, "name", name)
        _rich(statement, "declaration", said)
    for standard in content.standards:
        statement = _in(statements, "statement")
        _text(statement, "name", f"Traceability of {standard.name}")
        _in(statement, "traceable", "true" if standard.traceable else "false")
        if standard.certificate:
            _in(statement, "reference", " ".join(standard.certificate.split()))
        _rich(statement, "declaration", standard_text(standard))
    for verdict in content.conformity:
        statement = _in(statements, "statement")
        _text(statement, "name", f"Requirement {verdict.requirement}")
        _rich(statement, "declaration", verdict_text(verdict))
        conformity = CONFORMITY.get(verdict.verdict) or (f"conditional{verdict.lean}" if verdict.lean else None)
        if conformity is not None:
            _in(statement, "conformity", conformity)


def _statements(content: Content) -> Iterable[tuple[str, str]]:
    stated = content.stated
    if content.simulated:
        yield "Simulated data", SIMULATED
    yield "Items", ONLY_THESE
    yield "Reproduction", REPRODUCTION
    yield "Uncertainty", UNCERTAINTY
    if not content.is_traceable:
        yield "Traceability", NOT_TRACEABLE
    if any(one.matrix is not None for one in content.figures):
        yield "Sensor equation", EQUATION
    if content.refuted:
        yield "Closed loop", REFUTED
    yield "Deviations from the methods", stated.deviations
    if stated.place_text:
        yield "Place of the calibration", stated.place_text
    if stated.remarks:
        yield "Remarks", stated.remarks
    if content.conformity:
        yield "Decision rule", rules_text(content.conformity)
    yield "Source of the figures", f"Campaign {content.campaign}, results.json with checksum {content.results_checksum}"


def _software(parent: ET.Element, content: Content) -> None:
    software = _in(parent, "software")
    _text(software, "name", SOFTWARE)
    found = RELEASE.match(content.software)
    _in(software, "release", f"v{found[0]}" if found else "v0")
    _in(software, "type", "application")


def _item(parent: ET.Element, content: Content) -> None:
    maker, part, serial = content.item
    _text(parent, "name", part)
    _rich(parent, "description", f"State as received: {content.stated.item_condition}")
    _text(_in(parent, "manufacturer"), "name", maker)
    _in(parent, "model", part)
    identification = _in(_in(parent, "identifications"), "identification")
    _in(identification, "issuer", "manufacturer")
    _in(identification, "value", serial)
    _text(identification, "name", "serial number")


def _contact(parent: ET.Element, address: Address) -> None:
    _text(parent, "name", address.name)
    for name, value in (("eMail", address.email), ("phone", address.phone)):
        if value:
            _in(parent, name, value)
    location = _in(parent, "location")
    parts = {"street": address.street, "postCode": address.post_code, "city": address.city}
    for name, value in (parts | {"countryCode": address.country or ""}).items():
        if value:
            _in(location, name, value)


# Results


def _result(parent: ET.Element, content: Content, figures: Figures, first: bool) -> None:
    stated = content.stated
    _text(parent, "name", figures.what)
    methods = _in(parent, "usedMethods")
    for name in (*stated.methods, *(f"inertialcal, {one}" for one in content.procedures)):
        _text(_in(methods, "usedMethod"), "name", name)
    _software(_in(parent, "usedSoftware"), content)
    conditions = _in(parent, "influenceConditions")
    ranges = [("Environment", stated.environment), *(("Range", one) for one in figures.ranges)]
    for name, said in [*ranges, *([("Condition", figures.condition)] if figures.condition else [])]:
        condition = _in(conditions, "influenceCondition")
        _text(condition, "name", name)
        _rich(_in(condition, "data"), "text", said)
    data = _in_result(parent, figures.what)
    quantity = _in(data, "quantity")
    quantity.set("refType", FIGURES)
    _text(quantity, "name", figures.name)
    _list(_in(quantity, "realListXMLList", namespace=SI), figures)
    units = _in(data, "quantity")
    units.set("refType", UNITS)
    _text(units, "name", "Units as results.json has them; a count is a number in the D-SI")
    _in(units, "charsXMLList", " ".join(figures.units))
    if figures.matrix is not None and np.isfinite(figures.matrix[1]).any():
        axes, matrix = figures.matrix
        known = np.isfinite(matrix).ravel()
        quantity = _in(data, "quantity")
        quantity.set("refType", MATRIX)
        _text(
            quantity,
            "name",
            "Entries of the matrix that were estimated: first the sensor that reads, then the axis that moves",
        )
        made = _in(quantity, "realListXMLList", namespace=SI)
        labels = [f"M_{row}{column}" for row in axes for column in axes]
        _in(made, "labelXMLList", " ".join(one for one, is_known in zip(labels, known, strict=True) if is_known), SI)
        _in(made, "valueXMLList", _numbers(matrix.ravel()[known]), SI)
        _in(made, "unitXMLList", d_si("1"), SI)
    for what, why in figures.not_estimated:
        _rich(data, "text", f"{what}: not estimated" + (f": {why}" if why else ""))


def _in_result(parent: ET.Element, what: str) -> ET.Element:
    result = _in(_in(parent, "results"), "result")
    _text(result, "name", what)
    return _in(result, "data")


def _list(parent: ET.Element, figures: Figures) -> None:
    _in(parent, "labelXMLList", " ".join(figures.labels), SI)
    _in(parent, "valueXMLList", _numbers(figures.values), SI)
    _in(parent, "unitXMLList", " ".join(unit_list(figures.units)), SI)
    uncertainty = _in(parent, "measurementUncertaintyUnivariateXMLList", namespace=SI)
    p = repr(P)
    if figures.is_symmetric:
        made = _in(uncertainty, "expandedMUXMLList", namespace=SI)
        _in(made, "valueExpandedMUXMLList", _numbers(figures.expanded), SI)
        _in(made, "coverageFactorXMLList", _factors(figures.k), SI)
    else:
        made = _in(uncertainty, "coverageIntervalMUXMLList", namespace=SI)
        _in(made, "valueStandardMUXMLList", _numbers(figures.u), SI)
        _in(made, "intervalMinXMLList", _numbers(figures.lower), SI)
        _in(made, "intervalMaxXMLList", _numbers(figures.upper), SI)
    _in(made, "coverageProbabilityXMLList", " ".join([p] * len(figures.labels)), SI)
    if figures.covariance is None:
        return
    region = _in(_in(parent, "measurementUncertaintyMultivariateXMLList", namespace=SI),
                 "ellipsoidalRegionMUXMLList", namespace=SI)  # fmt: skip
    matrix = _in(region, "covarianceMatrixXMLList", namespace=SI)
    for column, unit in enumerate(figures.units):
        made = _in(_in(matrix, "columnXMLList", namespace=SI), "covarianceXMLList", namespace=SI)
        _in(made, "valueXMLList", _numbers(figures.covariance[:, column]), SI)
        _in(made, "unitXMLList", " ".join(unit_list([multiply(unit, other) for other in figures.units])), SI)
    factor = float(np.sqrt(chi_square_quantile(P, len(figures.labels))))
    _in(region, "coverageFactorXMLList", _factors([factor]), SI)
    _in(region, "coverageProbabilityXMLList", p, SI)


def unit_list(units: Sequence[str]) -> list[str]:
    """Return the units of a list in the D-SI: one for all where they are alike, as the Schematron recommends."""
    found = [d_si(one) for one in units]
    return found[:1] if len(set(found)) == 1 else found


def _numbers(values: Iterable[Any]) -> str:
    """Return numbers with all their digits."""
    return " ".join(repr(float(one)) for one in values)


def _factors(values: Sequence[float] | Any) -> str:
    """Return coverage factors: the schema has no exponents there."""
    return " ".join(f"{Decimal(repr(float(one))):f}" for one in values)
