"""Figures of a report: each taken from the cache where it was drawn before from the same data, else drawn."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from hashlib import sha256

from matplotlib import rcParams

from ...files.binary.objects import NotStorableError, digest
from ...report.drawings import Drawing
from .cache import Cache, packages
from .processes import each

KIND = "figure"
LEAST = 3  # figures that are worth a process


def drawn(wanted: Sequence[Drawing], cache: Cache) -> Mapping[str, str]:
    """Return figures as markup, by their key."""
    settings = sha256(repr(sorted(rcParams.items())).encode()).hexdigest()
    keys: dict[str, str] = {}
    found: dict[str, str] = {}
    for one in wanted:
        try:
            keys[one.key] = cache.key(one.key, settings, digest(one.picture, packages()))
        except NotStorableError:  # drawn from more than data
            continue
        kept = cache.get(KIND, keys[one.key])
        if kept is not None:
            found[one.key] = kept.decode()
    missing = [one for one in wanted if one.key not in found]
    made = each(lambda one: str(one.svg()).encode("utf-8", "surrogatepass"), missing, LEAST)
    for one, data in zip(missing, made, strict=True):
        found[one.key] = data.decode("utf-8", "surrogatepass")
        if one.key in keys:
            cache.put(KIND, keys[one.key], {}, data)
    return found
