"""The acceleration archive's pairs of data and header (PAD)."""
