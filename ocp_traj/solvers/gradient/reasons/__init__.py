"""Why there is no motion: proofs before anything is solved, and what stood in the way after a failure."""
