"""What `benchmarks.ways_out` is made of: a robot that notes what it is told and when, and an app that ends badly."""
