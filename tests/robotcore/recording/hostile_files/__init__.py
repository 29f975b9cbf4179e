"""Files that attack programs that read recordings."""
