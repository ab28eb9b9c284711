"""Power-ups held out: what the polynomial of another thermal test leaves of their bias."""
