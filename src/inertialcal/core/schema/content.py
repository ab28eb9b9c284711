"""Content of a file that is read back: every key there, of its kind, every number one that float64 can square."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, Field, ValidationError

from ..errors import DataError
from ..unit.magnitudes import DERIVED


def _derived(number: float) -> float:
    if not abs(number) <= DERIVED:
        raise ValueError(f"{number:g} is not a number from {-DERIVED:g} to {DERIVED:g}")
    return number


def _numbers(content: list[Any]) -> list[Any]:
    for one in content:
        if isinstance(one, list):
            _numbers(one)
        elif isinstance(one, bool) or not isinstance(one, int | float):
            raise ValueError(f"{one!r} is not a number")
        else:
            _derived(one)
    return content


Number = Annotated[float, AfterValidator(_derived)]
Numbers = Annotated[list[Any], AfterValidator(_numbers)]  # lists of lists of numbers, too
Pair = Annotated[list[Number], Field(min_length=2, max_length=2)]


class StatedInfluence(BaseModel):
    """Uncertainty of one quantity of a standard, as a certificate states it."""

    standard: str
    quantity: str
    u: Number
    unit: str
    certificate: str
    valid: str


def check_content(kind: type[BaseModel], content: Mapping[str, Any], where: str = "", do: str = "") -> None:
    """Refuse a content whose keys or values are not those of a schema.

    Parameters
    ----------
    kind : type
        The schema.
    content : mapping
        As parsed.
    where, do : str
        File, and the way out, for the message.

    Raises
    ------
    DataError
        ``schema``, with the first key that is wrong.
    """
    try:
        kind.model_validate(content)
    except RecursionError:
        raise DataError("lists within lists without end", where, do=do, code="schema") from None
    except ValidationError as error:
        wrong = error.errors(include_url=False)
        key = ".".join(str(part) for part in wrong[0]["loc"] if part != "")
        what = wrong[0]["msg"].removeprefix("Value error, ").replace("Input should be", "should be")
        more = f" (and {len(wrong) - 1} more)" if len(wrong) > 1 else ""
        raise DataError(
            f"{key}: {what}{more}", where, "the file does not hold what was written", do, "schema"
        ) from None
