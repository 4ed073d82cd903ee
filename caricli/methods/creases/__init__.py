"""What skin does with an expression: folds, and their colours."""
