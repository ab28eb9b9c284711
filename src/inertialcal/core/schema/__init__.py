"""What campaign files are made of: words, quantities, standards; for pydantic."""
