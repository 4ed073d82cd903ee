"""Surfaces that follow what is known of them in places."""
