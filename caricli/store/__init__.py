"""What several commands load by name or path, and write."""
