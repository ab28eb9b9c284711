"""The signal chain: counts to volts to units, and back."""
