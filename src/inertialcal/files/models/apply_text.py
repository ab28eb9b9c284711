"""How to apply a model, as code: the shortest that gives the numbers of ``sensors.model.compensate``.

For a report and for flight software: nothing of this package is needed to run it. What a model holds beside its
equation (covariance, run-to-run bias) is told in the head of the code; `inertialcal compensate` does those.
"""

from __future__ import annotations

from .apply_c import c_text
from .apply_python import python_text

__all__ = ["c_text", "python_text"]
