"""The best shape of an attracting mass, and the most that a mass can do."""

from .bound import Bound, largest_field
from .cells import Grid, best_cells, most_in_weight
from .gain import Gain, change
from .growth import Growth, growth
from .inventory import Pieces, Stack, best_stack
from .stated import Checked, checked

__all__ = [
    "Bound",
    "Checked",
    "Gain",
    "Grid",
    "Growth",
    "Pieces",
    "Stack",
    "best_cells",
    "best_stack",
    "change",
    "checked",
    "growth",
    "largest_field",
    "most_in_weight",
]
