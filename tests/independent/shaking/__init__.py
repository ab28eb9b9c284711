"""An item on a shaker, moved in time."""
