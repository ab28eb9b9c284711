"""A rate table of files without a campaign."""
