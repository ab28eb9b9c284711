"""Lots: one campaign for many units, each with its own recordings.

A lot is a campaign that serves as the template, a table of units, and where each unit's recordings lie. The unit is the
campaign with its own files, its serial number and what the table changes for it, and it is reduced as `run` reduces a
campaign. A unit that is refused is quarantined with its reason; the others go on.

Units are worked on in blocks of a fixed size, in the order of the table, by as many processes as are wanted, or by a
dask cluster; the ledger holds each unit that is done. What comes out does not depend on how many there were, nor on how
often the lot was interrupted.
"""
