"""Labelled pictures of balls, and the methods of finding a ball that are compared on them."""
