"""A microgravity head in orbit, turned by pi."""
