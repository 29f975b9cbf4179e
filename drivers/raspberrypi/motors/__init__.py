"""Motors on pins: which lines turn them, which duty makes which velocity, and how an encoder corrects it."""
