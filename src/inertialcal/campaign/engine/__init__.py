"""The engine: tests made ready, reduced, run."""
