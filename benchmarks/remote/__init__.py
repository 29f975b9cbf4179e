"""The parts of the benchmarks of simulator servers: doubles in processes, and a proxy that counts round trips."""
