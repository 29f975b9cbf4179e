"""The wheel on the processor of a Raspberry Pi, as QEMU emulates it for one program."""
