"""What several test files share: robots, commands, oracles."""
