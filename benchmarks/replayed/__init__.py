"""What happens to the runs that are recorded to be replayed."""
