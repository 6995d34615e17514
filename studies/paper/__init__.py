"""Reproduction of the paper: ``make paper`` writes docs/paper/ and its figures.

`tables` has the printed numbers, `days` simulates and analyses seven days of the three units, `decoding` finds the
cluster sizes of the printed errors, `rows` makes the tables of the pages, `figures` draws, `write` fills the pages.
"""
