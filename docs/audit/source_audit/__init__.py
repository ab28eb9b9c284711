"""The source audit: printed figures of the three documents against what their own data give."""
