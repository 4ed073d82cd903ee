"""What a user can ask for: one visible result a file."""
