"""robotcore_bridge on a simulated AVR, with a robot's electronics, and its serial line on a pty."""
