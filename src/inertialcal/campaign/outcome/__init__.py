"""What a run gives: results, verdicts, files."""
