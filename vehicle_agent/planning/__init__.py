"""Who decides where to go: planners with one interface, no I/O, no clock and an injected random generator."""
