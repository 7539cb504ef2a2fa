"""The parts of an agent's mind, each pure: what it shares, whom it hears, how it flies a leg, what it obeys."""
