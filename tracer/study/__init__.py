"""Studies: scenes, methods, budgets and seeds, measured side by side."""
