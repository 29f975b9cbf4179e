"""Run robotcore's wheel on an emulated arm64, the processor of a Raspberry Pi."""
