"""Flight C: raw codes to true inputs, with a bound on its arithmetic that is proved for all codes."""
