"""Measures the velocities, the dead band and the lag of a robot's motors."""
