"""Principal components and a Gaussian process."""
