"""The workbench in the browser: a server on this computer, and its page.

`routes` defines the requests and their answers; `guard` refuses all others; `calls` lists the functions that worker
processes (`workers`) run. They use public names of the other packages.
"""
