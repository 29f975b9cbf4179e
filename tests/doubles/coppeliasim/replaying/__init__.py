"""Replay recorded sessions of a real server on a double, and compare the replies."""
