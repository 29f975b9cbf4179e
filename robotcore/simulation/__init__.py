"""What the drivers of simulators share."""
