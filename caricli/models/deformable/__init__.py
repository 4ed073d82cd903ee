"""A SIREN hypernetwork."""
