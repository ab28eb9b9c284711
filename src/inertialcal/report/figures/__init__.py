"""Figures: those of every procedure and of a whole campaign, each drawn by a module that is loaded when it is.

A new figure is one module with ``pictures(results)`` and one ``FigureSpec``: among the ``figures`` of its procedure, or
in ``campaign/specs.py``.

``figures()["rate_error"].svg(results, test, axis)`` gives one for a page, ``.pictures(results)`` all of them, to be
drawn anywhere (``on_new_figure``).
"""

from __future__ import annotations

from .drawing.picture import Picture, on_new_figure
from .drawing.style import variables
from .drawing.svg import to_svg
from .registry import Figure, figures, prefix

__all__ = ["Figure", "Picture", "figures", "on_new_figure", "prefix", "to_svg", "variables"]
