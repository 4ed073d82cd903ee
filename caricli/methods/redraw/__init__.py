"""Pictures drawn again with another expression."""
