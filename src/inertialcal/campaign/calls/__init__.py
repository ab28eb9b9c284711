"""A procedure on files, Recordings or arrays: they become a campaign, which is reduced as any other."""
