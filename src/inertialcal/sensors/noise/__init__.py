"""Noise of a sensor as a sum of terms: what each looks like when sampled, which ones a record shows, and how large."""
