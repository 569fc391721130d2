"""Telling a comparison: statistics, tables, story, page."""
