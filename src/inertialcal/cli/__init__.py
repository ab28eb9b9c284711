"""The command line: words only. No figure is computed here; heavy imports stay inside commands."""
