"""The time axis of samples: stamps, schedules, decimation."""
