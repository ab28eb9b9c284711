"""Before there is a campaign: what a file holds, what to type next, a first campaign.toml for a folder."""
