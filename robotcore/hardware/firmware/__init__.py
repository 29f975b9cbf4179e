"""Finds, builds and flashes the firmware of a microcontroller board that drives the wheels."""
