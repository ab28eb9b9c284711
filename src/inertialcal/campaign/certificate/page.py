"""The page of a certificate: PDF/A-3b of one or two pages, with its XML attached."""

from __future__ import annotations

from importlib.resources import files
from math import isnan
from typing import Any

from ...core.show.rounding import with_uncertainty
from ...files.write.typst import typst_pdf
from ..file.certificate import Address
from .content import Content, Figures
from .words import (
    EQUATION,
    NOT_TRACEABLE,
    ONLY_THESE,
    REFUTED,
    REPRODUCTION,
    SIMULATED,
    TITLE,
    UNCERTAINTY,
    rules_text,
)

XML_NAME = "certificate.xml"
TEMPLATE = "page.typ"
MATRIX = (
    "M; row = sensor that reads, column = axis that moves; -: not estimated; its uncertainty is that of the figures"
)


def certificate_pdf(content: Content, xml: bytes) -> bytes:
    """Return the page as PDF/A-3b, the same bytes each time.

    Parameters
    ----------
    content : Content
        What it says.
    xml : bytes
        The same as XML, which is attached.

    Raises
    ------
    UsageError, StoreError
        As ``files.write.typst.typst_pdf``.
    """
    template = (files(__package__) / TEMPLATE).read_text(encoding="utf-8")
    issued = content.stated.issued
    assert issued is not None  # noqa: S101 - it is stated
    return typst_pdf(template, _data(content), issued, {XML_NAME: xml})


def _data(content: Content) -> dict[str, Any]:
    stated = content.stated
    maker, part, serial = content.item
    performed = " to ".join(dict.fromkeys(day.isoformat() for day in stated.performed or []))
    place = stated.place.replace("_", " ") + (f": {stated.place_text}" if stated.place_text else "")
    left = [["Laboratory", _address(stated.laboratory)], ["Place of calibration", place],
            ["Customer", _address(stated.customer)]]  # fmt: skip
    right = [
        ["Item", f"{maker} {part}"],
        ["Serial number", serial],
        ["State as received", stated.item_condition],
        ["Received", _day(stated.received)],
        ["Calibrated", performed],
        ["Issued", _day(stated.issued)],
    ]
    if stated.replaces:
        right.append(["Replaces", f"certificate {stated.replaces}"])
    method = [["Methods", "; ".join(stated.methods)], ["Evaluation", f"inertialcal {content.software}; "
               + "; ".join(content.procedures)],
              ["Environment", stated.environment], ["Deviations", stated.deviations]]  # fmt: skip
    if stated.remarks:
        method.append(["Remarks", stated.remarks])
    conditions = [one.condition for one in content.figures]
    # Two conditions stand side by side
    breaks = {conditions.index(one) for one in conditions[1:] if len(set(conditions)) == 2 and one != conditions[0]}
    equation = [EQUATION] if any(one.matrix is not None for one in content.figures) else []
    source = f"Figures: campaign {content.campaign}, results.json with checksum {content.results_checksum}."
    return {
        "title": TITLE,
        "number": stated.number,
        "laboratory_name": stated.laboratory.name,
        "simulated": SIMULATED if content.simulated else "",
        "left": left,
        "right": right,
        "method": method,
        "conformity": [[one.requirement, one.text or "-", one.verdict] for one in content.conformity],
        "rules": [f"Decision rule: {rules_text(content.conformity)}."] if content.conformity else [],
        "traceability": "" if content.is_traceable else NOT_TRACEABLE,
        "standards": [
            [
                one.name,
                one.u,
                one.certificate or "-",
                one.valid or "-",
                "traceable by its certificate" if one.traceable else f"not traceable: {one.why}",
            ]
            for one in content.standards
        ],
        "statements": [
            UNCERTAINTY,
            *equation,
            *([REFUTED] if content.refuted else []),
            ONLY_THESE,
            REPRODUCTION,
            source,
        ],
        "signatures": [[one.name, one.function] for one in stated.signatures],
        "figures": [_figures(one) | {"column_break": i in breaks} for i, one in enumerate(content.figures)],
        "xml_name": XML_NAME,
    }


def _day(day: Any) -> str:
    return "" if day is None else str(day.isoformat())


def _address(one: Address) -> str:
    town = " ".join(filter(None, (one.post_code, one.city)))
    return ", ".join(filter(None, (one.name, one.street, town, one.country, one.email, one.phone)))


def _figures(one: Figures) -> dict[str, Any]:
    symmetric = one.is_symmetric
    rows = []
    for i, quantity in enumerate(one.quantities):
        if symmetric:
            figure = with_uncertainty(float(one.values[i]), float(one.expanded[i]))
        else:
            figure = (
                f"{with_uncertainty(float(one.values[i]), float(one.u[i]))}, {one.lower[i]:.4g} .. {one.upper[i]:.4g}"
            )
        rows.append([quantity, figure, f"{one.k[i]:.2f}" if symmetric else "-", one.units[i]])
    axes, matrix = one.matrix if one.matrix is not None else ((), None)
    return {
        "what": one.what,
        "notes": "; ".join(one.ranges),
        "head": "value ± U" if symmetric else "value ± u, 95 % interval",
        "rows": rows,
        "axes": list(axes),
        "matrix": [] if matrix is None else [["-" if isnan(one) else f"{one:.7f}" for one in row] for row in matrix],
        "matrix_text": MATRIX,
        "lacking": [f"{what}: not estimated" + (f" ({why})" if why else "") for what, why in one.not_estimated],
    }


__all__ = ["XML_NAME", "certificate_pdf"]
