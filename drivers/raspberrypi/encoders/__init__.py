"""Encoders on pins: counters of edges that other threads report."""
