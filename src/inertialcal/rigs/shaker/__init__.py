"""An item on a shaker."""

TITLE = "an item on a shaker: sine survey before and after vibration"
