"""Doubles: programs that stand in for what a test run does not have, speaking its true protocols."""
