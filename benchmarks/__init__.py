"""What robotcore claims, measured: each module runs alone, ``python -m benchmarks.<name>``."""
