"""The workbench in the browser: a server on this computer, and its page.

`routes` defines the requests and answers; `guard` refuses other requests; `calls` is the work of worker processes
(`workers`), based on public names of the packages below.
"""
