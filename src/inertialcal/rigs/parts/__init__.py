"""Parts that several rigs share: noise, tables, turns of a head."""
