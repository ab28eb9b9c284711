"""What a file holds, and what to type next."""
