"""Hair of a picture on a head."""
