"""What every room builds on: arrays, kernels, random numbers, errors, files, processes."""
