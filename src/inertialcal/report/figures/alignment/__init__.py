"""Figures of an alignment at rest."""
