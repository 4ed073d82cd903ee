"""Principal components of deformation gradients."""
