"""The microgravity head with its ground model."""
