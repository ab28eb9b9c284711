"""A head in a space station: vibration of pumps and crew, slow acceleration along the orbit."""

TITLE = "an accelerometer head in a space station over one orbit, 12.5 samples a second"
