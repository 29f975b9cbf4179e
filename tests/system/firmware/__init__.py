"""robotcore_bridge on a simulated AVR, with a robot's electronics and its line on a pty."""
