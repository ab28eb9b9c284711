"""Two models or results set beside each other."""
