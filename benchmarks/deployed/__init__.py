"""What the benchmarks of deploying share."""
