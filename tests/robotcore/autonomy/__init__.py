"""Autonomy."""
