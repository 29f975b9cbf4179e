"""Checks on a GPIO chip and a camera that the kernel of a virtual machine simulates."""
