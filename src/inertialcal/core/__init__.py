"""The words that everything shares: recording, estimate, units, constants, errors, remarks."""
