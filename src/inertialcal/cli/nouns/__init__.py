"""Commands that work on files: a noun is a test."""
