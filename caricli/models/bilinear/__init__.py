"""Who somebody is times what the face does."""
