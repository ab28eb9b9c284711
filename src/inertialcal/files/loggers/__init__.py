"""Readers of loggers and test systems: bags, flight logs, data acquisition, workbooks."""
