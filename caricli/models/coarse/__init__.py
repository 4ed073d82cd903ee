"""The network from a picture to the coefficients of the morphable model."""
