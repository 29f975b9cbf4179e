"""The parts of `benchmarks.ways_out`: a robot that logs its commands, and an app that fails."""
