"""Rate table: scale factor, bias, misalignment and error of rate from dwells at known rates."""
