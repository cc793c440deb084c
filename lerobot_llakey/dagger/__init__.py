"""Learning from one's own mistakes: scenes that a policy gets itself into, labelled by the expert (DAgger)."""
