"""The parts of the benchmarks of simulator servers: doubles in processes, and a line that counts round trips."""
