"""The page of a study: one HTML file that shows pictures, errors, plots and tables without a network."""
