"""The workbench in the browser: a server on this computer, and its page.

`routes` says what the page asks and what is answered; `guard` refuses what is not for it; `calls` are what worker processes
do (`workers`), on public names of the rooms below.
"""
