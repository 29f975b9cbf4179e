"""Parts that the drivers of simulators share."""
