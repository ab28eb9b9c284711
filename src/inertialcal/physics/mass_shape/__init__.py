"""The best shape of an attracting mass, and the most that a mass can do."""
