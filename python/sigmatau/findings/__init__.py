"""Findings: what is known about a record beside its numbers, as typed data; words are made last, in `wording`."""
