"""Readers of text: delimited files, headers, tables."""
