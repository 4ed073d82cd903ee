"""Identity, expression and albedo."""
