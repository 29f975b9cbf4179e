"""Checks on the legacy remote API of a real simulator: ROBOTCORE_VREP=127.0.0.1:19997 python -m tests.system.vrep."""
