"""How a run looks: live in a terminal, as a summary, as one picture. Nothing here reads a device."""
