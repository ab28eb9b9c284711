"""The rate-sensor suite of a small satellite."""
