"""Waveshare UGV: JSON lines."""
