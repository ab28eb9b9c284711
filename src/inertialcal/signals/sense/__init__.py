"""Sense: what is physically possible, and changes of unit, sign, scale or axis inside a record."""
