"""The safety functions of a run, equal on every backend: command filter, rules, deadman, latch and watchdog.

This module imports none of them, so that the guardian process starts fast and stays small.
"""
