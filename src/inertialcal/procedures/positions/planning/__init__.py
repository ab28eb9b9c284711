"""Positions planned: which ones tell most."""
