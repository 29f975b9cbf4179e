"""The protocol of the legacy remote API: messages, requests, and a TCP connection that exchanges messages."""
