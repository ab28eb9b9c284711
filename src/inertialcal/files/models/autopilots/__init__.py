"""Autopilots: bias of each sensor as a polynomial of order 3 in one temperature, in files of parameters."""
