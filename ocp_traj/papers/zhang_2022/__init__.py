"""Zhang et al. 2022 (paper C)."""
