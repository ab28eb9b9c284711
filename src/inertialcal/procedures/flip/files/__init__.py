"""A flip of files without a campaign."""
