"""Sine survey: resonances of a vibrating item from a swept sine; before against after."""
