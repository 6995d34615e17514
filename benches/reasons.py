"""Reasons why targets are not reached, by the name of the target; the figures are from the tables and profiles of the
page.
"""

REASONS = {
    "main job over six bare curves": (
        "a quarter of the CPU time is the start of Python, NumPy and the command, which alone is more than half of the"
        " target; another quarter is reading. The bare curves check and fit nothing."
    ),
    "with a knock and 20 spikes, the same": (
        "the checks that find and confirm disturbances take half of the CPU time, the likelihood with missing samples a"
        " quarter, more than half of it for the masks, which differ from channel to channel. One fused pass of the checks"
        " over blocks was not tried."
    ),
    "ADIS16405 over its six bare curves": (
        "start and reading are as long as the target. The gyros have a filter, for which 18 shapes are fitted, and the"
        " accelerometers up to seven lines."
    ),
    "50 000 rows with motion, CPU time over earlier": (
        "more is imported, checked and fitted than in the earlier commit. Most logs take 0.9 to 1.1 times its CPU time, one"
        " with filtered gyros 1.2 to 1.4 times, because more shapes of filters are fitted. Half would need fewer checks."
    ),
    "185 000 rows with people, CPU time over earlier": "as for the rows with motion.",
    "a log of a folder, `--jobs 2`": (
        "a log takes 0.5 to 0.7 s of CPU time, about as in the earlier commit. The causes are those of the other logs."
    ),
    "24 hours, memory": "the samples alone have 0.83 GB; checks hold further copies of a channel at a time.",
    "largest power of the cost, `sigmatau.analyze`, 600 samples of each channel": "within the scatter of the target.",
    "`--jobs 2` over `--jobs 1`": (
        "one job overlaps reading, checksum and JSON already, and so uses more than one core; two jobs share the memory's"
        " bandwidth, so that the same work takes a tenth to a quarter more CPU time."
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
