"""Checks on a real CoppeliaSim: ROBOTCORE_COPPELIASIM=127.0.0.1:23000 python -m tests.system.coppeliasim."""
