"""Pictures of balls with labels, and the finders that `benchmarks.detector` compares on them."""
