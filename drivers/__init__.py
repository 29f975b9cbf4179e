"""One folder a backend; each knows robotcore and its own vendor library, none knows another."""
