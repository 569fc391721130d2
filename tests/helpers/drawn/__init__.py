"""Tasks drawn at random."""
