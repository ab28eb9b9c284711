"""Simulators that share no code with inertialcal, and what its commands make of their files.

The simulators (:mod:`static`, :mod:`rate_table`, :mod:`thermal`, :mod:`positions`, :mod:`moved_mass`, :mod:`flip`) and
:mod:`faults` import numpy and scipy only: a test walks their imports. Only :mod:`trial`, :mod:`gate`,
:mod:`studies`, :mod:`coverage` and :mod:`screened` call inertialcal. Every draw comes from a seed that is given.
"""
