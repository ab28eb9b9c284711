"""Commands that work on a campaign or a model."""
