"""Motors that write down what they are told, and a cutoff that writes that they stand."""
