"""Distances: by sound, timed on two pins, and by light, over I2C."""
