"""Sensors: from counts to units (chain), from units to the true input (model), published sensors as data."""
