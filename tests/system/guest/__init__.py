"""Checks on a kernel's simulated GPIO chip and camera; tests/system/gpio runs them in its virtual machine."""
