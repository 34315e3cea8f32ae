"""Find the differences of two .mbs files: match entities, then compare their values."""
