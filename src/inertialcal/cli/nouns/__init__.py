"""Nouns: the commands of procedures, made of their settings."""
