"""Pictures made caricatures before a face is reconstructed from them: shape, and paint."""
