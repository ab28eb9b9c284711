"""Positions held out: how a fit does on positions and rotations that it has not seen."""
