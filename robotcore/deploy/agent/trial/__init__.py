"""A new release proves itself, or is taken back."""
