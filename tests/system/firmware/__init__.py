"""Our firmware on a simulated AVR, with a robot's electronics around it and its line on a pty."""
