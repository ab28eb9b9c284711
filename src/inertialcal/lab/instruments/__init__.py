"""Instruments: protocol, dialects (as data), links (how bytes come), devices of the two, some to rehearse on."""
