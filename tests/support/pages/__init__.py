"""Pages as a test makes them, and as a browser opens them."""
