"""The models of one sensor, each for a condition, such as air and vacuum."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from ...core.errors import DataError, UsageError
from ...core.key import Kind
from .sensor_model import SensorModel


@dataclass(frozen=True, eq=False)
class ModelSet(Mapping[str, SensorModel]):
    """Condition -> model; one model for every condition has the key ``""``.

    Raises
    ------
    DataError
        If there is no model, or two of one condition; if they are not of one sensor.
    """

    models: tuple[SensorModel, ...]

    def __post_init__(self) -> None:
        names = [one.condition for one in self.models]
        if not names or len(set(names)) != len(names) or (len(names) > 1 and "" in names):
            raise DataError(f"models of conditions {names}: need one model a condition")
        if len({(one.item, one.kind, one.axes) for one in self.models}) > 1:
            raise DataError("the models are not of one sensor", do="Take models of one item, kind and axes")

    def __getitem__(self, condition: str) -> SensorModel:
        """Return the model of a condition."""
        for one in self.models:
            if one.condition == condition:
                return one
        raise KeyError(condition)

    def __iter__(self) -> Iterator[str]:
        """Conditions, in the order of the models."""
        return (one.condition for one in self.models)

    def __len__(self) -> int:
        """Return the number of models."""
        return len(self.models)

    @property
    def kind(self) -> Kind:
        """What the sensor senses."""
        return self.models[0].kind

    def only(self, condition: str | None = None, where: str = "") -> SensorModel:
        """Return the model of a condition, or the one that there is.

        Parameters
        ----------
        condition : str, optional
            Whose model is wanted.
        where : str
            File, for messages.

        Raises
        ------
        UsageError
            ``condition_needed`` where there are several and none is named; ``no_such_condition``.
        """
        known = [one for one in self if one]
        if condition is None:
            if len(self) == 1:
                return self.models[0]
            raise UsageError(
                f"models for several conditions: {', '.join(known)}",
                where,
                why="readings in one condition need the model of that condition",
                do=f"Say which: {' or '.join(f'--condition {one}' for one in known)}",
                code="condition_needed",
            )
        if condition in self:
            return self[condition]
        raise UsageError(
            f"no model for condition {condition!r}",
            where,
            do=f"There is: {', '.join(known)}" if known else "The model names no condition: leave the condition out",
            code="no_such_condition",
        )
