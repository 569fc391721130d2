"""Zhu and Wang (paper D); the text we have prints no year."""
