"""Findings about samples: what is wrong with a record before anything is computed from it.

One module a kind of fault; each takes a stream and returns findings.
"""
