"""The parts of `benchmarks.run_endings`: a robot that logs its commands, and an app that fails."""
