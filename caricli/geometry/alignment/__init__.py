"""Rotations, similarities and cameras that bring points onto others."""
