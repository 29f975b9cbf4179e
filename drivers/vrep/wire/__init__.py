"""The legacy remote API on the wire: messages, requests, and a TCP connection that exchanges them."""
