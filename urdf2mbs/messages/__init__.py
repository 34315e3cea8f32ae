"""What is said to the person at the keyboard: errors, warnings, notes, and how much each weighs."""
