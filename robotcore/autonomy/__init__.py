"""Algorithms for apps: vision and navigation."""
