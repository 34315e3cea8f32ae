"""The commands, a file each: its options, what it does, what it prints."""
