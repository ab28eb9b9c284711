"""A model of a rate table: its terms, and its closed loop on dwells held out."""
