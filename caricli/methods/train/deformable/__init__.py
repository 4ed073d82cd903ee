"""Training of the hypernetwork that makes shapes."""
