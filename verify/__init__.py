"""What is proven: every state that the running code can come to on a small line, and a certificate of it."""
