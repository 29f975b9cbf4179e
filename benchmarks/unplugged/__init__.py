"""The parts of `benchmarks.serial_unplugged`: the boards, and the app that drives them."""
