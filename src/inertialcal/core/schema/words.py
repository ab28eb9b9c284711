"""Words that all tables of campaign.toml are made of.

Unknown keys are refused: a misspelt key would be a setting that silently does nothing.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

Name = Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]*$", max_length=64)]
Text = Annotated[str, Field(max_length=2000)]
Axis = Literal["x", "y", "z"]
PerAxis = str | dict[Axis, str]  # one quantity for all axes, or one each


class Strict(BaseModel):
    """Unknown keys are refused; nothing changes after reading."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)
