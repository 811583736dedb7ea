"""Malformed inputs for every reader: each may be refused in a sentence, none may end in a traceback or a crash."""
