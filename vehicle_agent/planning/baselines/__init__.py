"""The rivals of the papers, behind the same interface."""
