"""How far a figure can be trusted: means, fits, intervals, propagation and decisions.

Everything here is arrays in, frozen results out: no files, no clock, no random state of its own.
Standard uncertainties are written ``u``, degrees of freedom ``dof`` (infinite where the size of an
uncertainty is taken as known), and ``dof == 0`` always means that the scatter was not estimated.
"""
