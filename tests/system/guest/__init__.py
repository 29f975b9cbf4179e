"""Checks on a real kernel's GPIO chip and camera: run by tests/system/gpio, in its virtual machine."""
