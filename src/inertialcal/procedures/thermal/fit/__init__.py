"""The law of bias over temperature fitted to ramps."""
