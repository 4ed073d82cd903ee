"""Lines as points: along them, between them, and from ink."""
