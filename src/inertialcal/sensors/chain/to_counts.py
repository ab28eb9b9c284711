"""From readings back to counts: what a converter makes of them, for rigs and for round trips."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...core.errors import DataError
from ...core.estimate import Array
from .converter import Chain, missing_channel, wide, zero_at_gains


def to_counts(
    chain: Chain,
    readings: ArrayLike,
    *,
    reference: ArrayLike | None = None,
    temperature: ArrayLike | None = None,
    gain: ArrayLike | None = None,
) -> NDArray[np.int64]:
    """Return the codes that a converter gives for readings: the inverse of `convert`.

    Parameters
    ----------
    readings : array_like, shape (n, k)
        [input unit]; outputs where the chain has no scale factor.
    reference : array_like, shape (n,) or (n, k), optional
        Codes of the reference voltage.
    temperature : array_like, shape (n,) or (n, k), optional
        Of the electronics [degC], where their zero depends on it.
    gain : array_like, shape (n,) or (n, k), optional
        Over time; instead of the chain's.

    Returns
    -------
    ndarray of int64, shape (n, k)
        The nearest codes; beyond the ends, the end.

    Raises
    ------
    DataError
        ``missing_reference`` or ``missing_temperature``.
    """
    k = len(chain.axes)
    wanted = wide("readings", readings, k)
    degrees = None if temperature is None else wide("temperature", temperature, k, len(wanted))
    over_time = None if gain is None else wide("gain", gain, k, len(wanted))
    amplified = chain.gain if over_time is None else over_time
    output = wanted if chain.scale_factor is None else wanted * chain.scale_factor
    return _codes(chain, output * amplified + zero_at_gains(chain, degrees, over_time), reference)


def to_temperature_counts(
    chain: Chain, temperature: ArrayLike, *, reference: ArrayLike | None = None
) -> NDArray[np.int64]:
    """Return the codes of the temperature channel, shape (n, k), at temperatures [degC].

    Raises
    ------
    DataError
        ``missing_temperature`` if the chain has no thermometer; ``missing_reference``.
    """
    if chain.thermometer is None:
        raise DataError("the chain has no thermometer", code="missing_temperature")
    return _codes(chain, chain.thermometer.volts(wide("temperature", temperature, len(chain.axes))), reference)


def _codes(chain: Chain, volts: Array, reference: ArrayLike | None) -> NDArray[np.int64]:
    """Nearest codes of volts above the reference."""
    if chain.reference != "channel":
        above: Array | float = chain.reference
    elif reference is None:
        raise missing_channel(chain, "reference", "the chain subtracts a reference voltage sample by sample")
    else:
        above = chain.step * wide("reference", reference, len(chain.axes), len(volts))
    codes = np.rint((volts + above) / chain.step)
    return (codes if chain.codes is None else np.clip(codes, *chain.codes)).astype(np.int64)
