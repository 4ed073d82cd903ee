"""The training of the network that tells what strokes draw."""
