"""Shape models behind one interface."""
