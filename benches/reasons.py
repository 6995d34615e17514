"""Reasons why targets are not reached, by the name of the target; the figures are from the tables and profiles of the
page.
"""

REASONS = {
    "2.8 hours of an ADIS16405, 100 Hz, compressed text": (
        "within the scatter of the target; checks of samples and fits take half of it. The accelerometers have up to seven"
        " lines, each fitted, and a step of the log as large as the noise."
    ),
    "50 000 rows with motion, a step and spikes": (
        "within the scatter of the target: 0.27 s of CPU time are the start of Python and NumPy, the rest are the checks"
        " that find the disturbances and the fits beside them."
    ),
    "`--jobs 2` over `--jobs 1`": (
        "one job overlaps reading, checksum and JSON already, and so uses more than one core; two jobs share the memory's"
        " bandwidth, so that the same work takes a tenth more CPU time."
    ),
    "six axes, two threads, octaves": (
        "half of six times one axis on one thread is nine tenths of the time. One axis is limited by the running sum into"
        " new memory and by windows that are farther apart than the cache is large; see the kernels below."
    ),
    "six axes, two threads, 100 log-spaced": (
        "as for octaves: with many averaging times most windows come from the memory that both cores share."
    ),
    "octave kernel, 1 440 000 samples, share of the limit": (
        "in the first-level cache the kernel runs at the limit (69 ps a term). Windows 256 kB apart share the same lines of"
        " the second-level cache, 33 of them for 8 ways, and cost 99 ps and more. Copies of these windows into strips were"
        " three times slower."
    ),
    "log to curves, pandas + allantools": (
        "of the 0.7 s of CPU time 29 % are the start of Python and NumPy, 26 % the conversion of numbers (18 ns for 18"
        " digits, eight at a time), 22 % the kernel, 10 % finding the fields. Ten times would be 0.2 s, of which NumPy's"
        " import alone is 0.08 s."
    ),
}
