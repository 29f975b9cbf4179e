"""Measures how far a recorded run and its simulation with the same commands part."""
