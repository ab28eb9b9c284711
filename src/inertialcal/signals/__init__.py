"""What recordings look like: time axis, codes, quiet and moving stretches; arrays in, arrays out."""
