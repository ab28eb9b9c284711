"""Vibration effects: rectification, g-sensitivity to vibration and noise of a sensor that rides on a shaker."""
