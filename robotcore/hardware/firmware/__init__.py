"""The firmware for a microcontroller that drives the wheels: where it is, how it is built, and how it gets there."""
