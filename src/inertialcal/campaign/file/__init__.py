"""campaign.toml: what may stand in it, read and checked."""
