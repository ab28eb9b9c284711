"""A microgravity head in orbit, turned by pi."""

TITLE = "a triaxial accelerometer head turned by half a turn, and back, in orbit"
