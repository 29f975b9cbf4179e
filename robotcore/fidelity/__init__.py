"""Measures how much a recorded run and its simulation with the same commands differ."""
