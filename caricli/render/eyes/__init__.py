"""Eyes: what a picture shows of them, and eyeballs that look so."""
