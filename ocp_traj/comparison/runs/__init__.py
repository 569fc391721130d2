"""Running a comparison: plan, processes, store."""
