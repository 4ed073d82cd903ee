"""What files hold, and whether it is whole."""
