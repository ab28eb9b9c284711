"""A certificate of a campaign written to a file: the page with its XML attached, or the XML alone."""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass
from pathlib import Path

from ...core.errors import UsageError
from ...files.source import checked_path
from ...files.write.atomic import atomic_write
from .content import content_of
from .dcc import dcc_xml
from .page import certificate_pdf
from .signature import signed

SUFFIXES = (".pdf", ".xml")


@dataclass(frozen=True)
class IssuedCertificate:
    """A certificate that was written.

    Parameters
    ----------
    path, sha256 : str
        The file.
    number : str
        Of the certificate.
    figures : int
        How many it holds.
    traceable : bool
        Whether every standard has a certificate that was valid.
    signed : bool
        Whether its XML is signed.
    warnings : tuple of str
        What it says of standards that are not traceable, and of simulated data.
    """

    path: str
    sha256: str
    number: str
    figures: int
    traceable: bool
    signed: bool
    warnings: tuple[str, ...]

    def __str__(self) -> str:
        """Return what was written, and what it warns of, as text."""
        state = "traceable" if self.traceable else "not traceable"
        head = f"certificate {self.number} written to {self.path}: {self.figures} figures, {state}"
        return "\n".join([f"{head}{', signed' if self.signed else ''}", *(f"  {one}" for one in self.warnings)])


def certificate(
    folder: str | os.PathLike[str],
    output: str | os.PathLike[str],
    sign_key: str | os.PathLike[str] | None = None,
    sign_certificate: str | os.PathLike[str] | None = None,
) -> IssuedCertificate:
    """Write the certificate of a campaign that was run; what the campaign does not state is refused in one list.

    Parameters
    ----------
    folder : path
        Of the campaign, whose campaign.toml has a table [certificate].
    output : path
        ``*.pdf``: one or two pages, PDF/A-3b, with the XML attached; ``*.xml``: a digital calibration certificate.
    sign_key, sign_certificate : path, optional
        Private key and certificate of the signer (PEM): the XML is signed.

    Raises
    ------
    UsageError
        ``unsupported_format`` for another ending; ``missing_extra``; ``half_a_signature`` for a key without its
        certificate.
    PlanError, DataError
        As ``content_of`` and ``signed``.
    StoreError
        ``not_written``; ``not_typeset``.
    """
    ending = Path(checked_path(output)).suffix.lower()
    checked_path(folder, "campaign")
    if ending not in SUFFIXES:
        do = "Name a file that ends in .pdf or .xml"
        raise UsageError(f"{output}: no format of a certificate", do=do, code="unsupported_format")
    if (sign_key is None) != (sign_certificate is None):
        do = "Give both: --sign-key KEY.pem --sign-certificate CERT.pem"
        raise UsageError("a key without its certificate, or the reverse", do=do, code="half_a_signature")
    content = content_of(folder)
    made = xml = dcc_xml(content)
    if sign_key is not None and sign_certificate is not None:
        made = xml = signed(xml, sign_key, sign_certificate)
    if ending == ".pdf":
        made = certificate_pdf(content, xml)
    kept = [Path(folder) / "campaign.toml", *(one for one in (sign_key, sign_certificate) if one is not None)]
    with atomic_write(output, kept) as aside:
        aside.write_bytes(made)
    return IssuedCertificate(
        str(output),
        hashlib.sha256(made).hexdigest(),
        content.stated.number,
        sum(len(one.labels) for one in content.figures),
        content.is_traceable,
        sign_key is not None,
        content.warnings,
    )
