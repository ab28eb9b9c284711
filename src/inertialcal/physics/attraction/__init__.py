"""Attraction of bodies: field, gradient, and the mean over a proof mass."""

from .bodies import Body, Composite, Placed, Point, Prism, Sphere
from .cylinder import Cylinder
from .extended import ProofMass, mean_field
from .field import attraction, attraction_gradient
from .lattice import Lattice
from .ring import Ring
from .tilt import surface_tilt

__all__ = [
    "Body",
    "Composite",
    "Cylinder",
    "Lattice",
    "Placed",
    "Point",
    "Prism",
    "ProofMass",
    "Ring",
    "Sphere",
    "attraction",
    "attraction_gradient",
    "mean_field",
    "surface_tilt",
]
