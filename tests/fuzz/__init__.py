"""Coverage-guided fuzzing of every reader: ``make fuzz``, and for a short while among the tests."""
