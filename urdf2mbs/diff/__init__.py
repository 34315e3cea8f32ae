"""What differs between two .mbs files: which objects are the same, and what of them changed."""
