"""Benchmarks for the claims of the documentation. Each module runs alone: ``python -m benchmarks.<name>``."""
