"""The studio: a page on one's own machine for what needs a hand. It calls methods and the store, as commands do."""
