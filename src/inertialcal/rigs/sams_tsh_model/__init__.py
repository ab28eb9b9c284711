"""The microgravity head with its ground model."""

TITLE = "a triaxial accelerometer head with its ground model, turned by half a turn, and back, in orbit"
