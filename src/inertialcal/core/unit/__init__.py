"""Text of a unit, read and spelled: tokens, atoms, powers."""
