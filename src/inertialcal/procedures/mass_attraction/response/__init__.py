"""Response of each run to the moved mass, and the runs together."""
