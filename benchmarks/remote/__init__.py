"""What the benchmarks of simulators that are servers are made of: doubles as processes, and a line that is counted."""
