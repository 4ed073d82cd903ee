"""Pictures on faces."""
