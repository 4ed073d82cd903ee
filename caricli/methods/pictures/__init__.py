"""Pictures of known faces, with all that is known of them."""
