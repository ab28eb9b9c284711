"""Figures of a shifted ground model."""
