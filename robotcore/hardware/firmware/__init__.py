"""Find, build and flash the firmware for a microcontroller that drives the wheels."""
