"""Many runs from one plan: a list, a store addressed by content, workers, and one dataset of all results."""
