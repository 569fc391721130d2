"""Ma et al. 2024 (paper B)."""
