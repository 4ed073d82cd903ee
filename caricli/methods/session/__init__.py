"""Sessions of the studio: what operations do to what is worked on, and how they are done again."""
