"""Measures a camera: its intrinsics, its noise and its delay, and the colour of an object before it."""
