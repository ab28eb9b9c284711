"""Writers of recordings, and files replaced in one go."""
