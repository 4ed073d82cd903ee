"""The nouns: frozen, checked once where they are made, without paths."""
