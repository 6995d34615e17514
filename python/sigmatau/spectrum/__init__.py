"""Power spectral densities of a record, two-sided.

Welch's average of tapered segments for all frequencies, and the multitaper estimate with sine tapers for the low ones, where
a record has few segments to average.

References
----------
.. [1] P. D. Welch, "The use of fast Fourier transform for the estimation of power spectra," IEEE Trans. Audio
   Electroacoust., vol. 15, no. 2, 1967, :doi:`10.1109/TAU.1967.1161901`.
.. [2] K. S. Riedel, A. Sidorenko, "Minimum bias multiple taper spectral estimation," IEEE Trans. Signal Process., vol. 43,
   no. 1, 1995, :doi:`10.1109/78.365298`.
"""
