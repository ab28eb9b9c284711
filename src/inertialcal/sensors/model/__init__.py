"""The sensor equation, its terms, and compensation."""
