"""The morphable model against pictures: coefficients, renderer and energy of the portrait paper, section 3.1."""
