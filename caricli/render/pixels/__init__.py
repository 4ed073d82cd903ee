"""Pictures as arrays: windows, masks, colours, strokes."""
