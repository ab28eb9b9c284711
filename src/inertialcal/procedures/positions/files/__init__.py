"""Positions of files without a campaign: which channel is what, and the call."""
