"""Reports that people look at: one HTML file that holds all of itself."""
