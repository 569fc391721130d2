"""Optimisers: one file per method, equation numbers at the line."""
