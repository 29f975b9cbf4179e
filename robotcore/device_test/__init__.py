"""Tests the wiring and the mounting of a robot's devices, and corrects the robot's file."""
