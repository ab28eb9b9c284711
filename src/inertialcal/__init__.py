"""inertialcal: from raw counts to a calibration that can be trusted."""
