"""Show a run as a progress line, as text, as pictures and as videos. No module here reads a device."""
