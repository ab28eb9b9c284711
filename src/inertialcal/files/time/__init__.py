"""Which column is time, and what its stamps mean."""
