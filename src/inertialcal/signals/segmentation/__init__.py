"""A record cut into dwells, placements, turns and steps."""
