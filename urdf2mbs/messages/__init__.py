"""Messages for the user: errors, warnings and notes."""
