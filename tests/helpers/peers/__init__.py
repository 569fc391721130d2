"""Adapters to other libraries that solve one of our problems."""
