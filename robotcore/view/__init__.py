"""Show a run: a progress line, text, pictures, videos. No module here reads a device."""
