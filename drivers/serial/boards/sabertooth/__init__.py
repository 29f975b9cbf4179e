"""Sabertooth in packet serial mode: write-only frames of four bytes."""
