"""Pictures of balls with the truth about them, and the ways to find a ball that are measured on them."""
