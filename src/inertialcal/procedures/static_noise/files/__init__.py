"""Noise of files without a campaign: Allan deviation, spectrum, numbers for filters."""
