"""Measures the wheel radius and the track of a robot."""
