"""Lines fitted to dwells, and what follows from them."""
