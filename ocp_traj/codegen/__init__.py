"""Small CasADi functions as machine code or NumPy programs."""
