"""Recordings as a campaign describes them: channels, chains, ground models, sources."""
