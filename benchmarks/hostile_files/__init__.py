"""Files made to break what reads recordings."""
