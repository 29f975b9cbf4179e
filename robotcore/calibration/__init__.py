"""Measures the parts of a robot, and corrects the robot's file."""
