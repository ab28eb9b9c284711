"""Model files: ours, those of others, and code that applies a model."""
