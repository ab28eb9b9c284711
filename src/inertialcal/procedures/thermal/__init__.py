"""Thermal: bias over temperature from ramps, in air or in vacuum, with what differs between paths and power-ups."""
