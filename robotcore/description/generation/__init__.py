"""Draws worlds from a seed."""
