"""Pictures as data, and what draws them: SVG for self-contained pages, Matplotlib for files."""
