"""The command line: thin commands over the library, which load what they need when they run."""
