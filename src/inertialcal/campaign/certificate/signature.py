"""An enveloped XML signature of a certificate (W3C XML Signature), made and verified by signxml.

A signature proves who signed and that nothing was changed since, if the certificate of the signer comes from elsewhere:
one that lies in the file proves nothing, and is not used.
"""

from __future__ import annotations

import os
from typing import Any

from ...core.errors import DataError, UsageError
from ...files.source import load
from ...files.xml_text import xml_root

SIGNATURE = "{http://www.w3.org/2000/09/xmldsig#}Signature"
NOT_SIGNED, NOT_VERIFIED, VERIFIED = "not signed", "signed, not verified", "verified"


def _signxml() -> Any:
    try:
        import signxml  # noqa: PLC0415 - an extra
    except ImportError:
        do = "Type: pip install 'inertialcal[sign]'"
        raise UsageError("signatures need signxml, which is not installed", do=do, code="missing_extra") from None
    return signxml


def signed(xml: bytes, key: str | os.PathLike[str], certificate: str | os.PathLike[str]) -> bytes:
    """Return the XML with its signature, and the certificate of the signer in it.

    Parameters
    ----------
    xml : bytes
        A certificate as ``dcc_xml`` gives it.
    key, certificate : path
        Private key and certificate of the signer (PEM).

    Raises
    ------
    DataError
        ``wrong_key``, if the key or the certificate cannot be used, or they do not belong together.
    UsageError
        ``missing_extra`` where signxml is not installed.
    """
    signxml = _signxml()
    from lxml import etree  # noqa: PLC0415 - comes with signxml

    private, public = load(key, document=True).data, load(certificate, document=True).data
    try:
        root = signxml.XMLSigner().sign(_parsed(xml), key=private, cert=public.decode("ascii"))
        made: bytes = etree.tostring(root, encoding="UTF-8", xml_declaration=True)
        signxml.XMLVerifier().verify(made, x509_cert=public.decode("ascii"))
    except UsageError:
        raise
    except Exception as error:  # signxml and its libraries raise what they like
        what = f"cannot sign with this key and certificate: {type(error).__name__}: {' '.join(str(error).split())}"
        do = "Give a private key without passphrase and the certificate that belongs to it, both PEM"
        raise DataError(what, str(key), do=do, code="wrong_key") from None
    return made


def signature_of(xml: bytes, where: str, certificate: str | os.PathLike[str] | None = None) -> tuple[str, bytes]:
    """Return what is known of the signature of an XML, and what to read: of a verified one, what is signed alone.

    Parameters
    ----------
    xml : bytes
        As it lies there.
    where : str
        File, for messages.
    certificate : path, optional
        Of the signer, to verify with.

    Raises
    ------
    DataError
        ``wrong_signature``, ``not_signed``.
    UsageError
        ``missing_extra``.
    """
    count = len(xml_root(xml).findall(f".//{SIGNATURE}"))
    if certificate is None:
        return (NOT_VERIFIED if count else NOT_SIGNED), xml
    if not count:
        do = "Ask the laboratory for the signed one"
        raise DataError("not signed", where, "nothing shows who made it", do, "not_signed")
    signxml = _signxml()
    public = load(certificate, document=True).data
    try:
        found = signxml.XMLVerifier().verify(_parsed(xml), x509_cert=public.decode("ascii"))
        read = _bytes(found.signed_xml)
    except UsageError:
        raise
    except Exception as error:  # signxml and its libraries raise what they like
        said = " ".join(str(error).split())
        why = f"it was changed after it was signed, or another one signed it: {type(error).__name__}: {said}"
        raise DataError("the signature is wrong", where, why, "Do not use it", "wrong_signature") from None
    return VERIFIED, read


def _parsed(xml: bytes) -> Any:
    from lxml import etree  # noqa: PLC0415 - comes with signxml

    xml_root(xml)  # refuses a document type
    return etree.fromstring(xml, etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False))


def _bytes(element: Any) -> bytes:
    from lxml import etree  # noqa: PLC0415 - comes with signxml

    made: bytes = etree.tostring(element)
    return made
