"""Microgravity environment: archive records against a requirement curve, and their slow acceleration."""
