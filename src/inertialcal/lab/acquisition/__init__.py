"""Acquisition: LAB.toml, what goes on while it runs, the recording, the clocks, and what is sealed in the end."""
