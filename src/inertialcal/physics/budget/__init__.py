"""Budget of the acceleration that a moved mass applies."""

from .linear import Share, linear_budget, shares
from .monte_carlo import compared, monte_carlo_budget
from .source import Doubts, Source

__all__ = ["Doubts", "Share", "Source", "compared", "linear_budget", "monte_carlo_budget", "shares"]
