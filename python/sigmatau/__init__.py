"""Allan variance and noise models of inertial sensors.

>>> import sigmatau as st
>>> record = st.read("static.csv", unit={"gyro": "deg/s", "accel": "g"})  # doctest: +SKIP
>>> st.analyze(record)  # doctest: +SKIP

The public names are listed once, in `__init__.pyi`. Each is imported on first use: importing the package loads NumPy at
most, and matplotlib is loaded by a figure. An analysis needs no SciPy.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
