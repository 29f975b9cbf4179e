"""How a project is proven at the desk, in processes of their own."""
