"""The lifted form: every knot's state, tied by continuity equations; what gradient solvers get."""
