"""A map between landmarks of normal faces and caricatures."""
