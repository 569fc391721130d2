"""The judge's own numerics: Chebyshev series, roots of polynomials, exact ends of pieces."""
