"""The structures of arrays that several stages read and write."""
