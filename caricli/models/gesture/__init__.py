"""The network that tells pen gestures apart."""
