"""The legacy remote API on the line: packets, messages, requests and the values in them, over one TCP connection."""
