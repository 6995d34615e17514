"""Figures of known Allan deviations, drawn by Matplotlib or written by hand, and small PDF files."""

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

# A tactical gyro. [SI]
TRUTH = {"random_walk": np.radians(0.3 / 60), "bias_instability": np.radians(12 / 3600), "rate_random_walk": 4.85e-6}
TERMS = ("quantization", *TRUTH)
DEGREES_PER_HOUR = np.degrees(1) * 3600
FORMATS = {
    "texts.svg": {"svg.fonttype": "none"},
    "outlines.svg": {"svg.fonttype": "path"},
    "type3.pdf": {"pdf.fonttype": 3},
    "type42.pdf": {"pdf.fonttype": 42},
}


def deviation(tau):
    """Allan deviation of `TRUTH`. [rad/s]"""
    walk, instability, slow = TRUTH.values()
    return np.sqrt(walk**2 / tau + 2 * np.log(2) / np.pi * instability**2 + slow**2 * tau / 3)


def times(count=45, shortest=0.01, longest=3000.0):
    return np.unique(np.round(np.geomspace(shortest, longest, count), 2))


def figure(*, grid=True, size=(6.4, 4.8)):
    """A figure with logarithmic axes in s and deg/h."""
    result = Figure(figsize=size)
    axes = result.add_subplot()
    axes.set(xscale="log", yscale="log", xlabel="τ [s]", ylabel="σ [deg/h]")
    axes.grid(visible=grid, which="both")
    return result, axes


def saved(result, path, **settings):
    with mpl.rc_context(FORMATS.get(path.name, {}) | settings):
        result.savefig(path)
    return path


def drawn(path, *, tau=None, width=1.5, size=(6.4, 4.8), grid=True, **settings):
    """A figure with the curve of `TRUTH` in blue."""
    result, axes = figure(grid=grid, size=size)
    tau = times() if tau is None else tau
    axes.plot(tau, DEGREES_PER_HOUR * deviation(tau), color="#1f77b4", linewidth=width)
    return saved(result, path, **settings)


# As Illustrator and spreadsheets write: entities for the namespace, a style sheet, nested groups, a scaled smooth curve in
# relative coordinates, grid lines in one path, plain labels with anchors.
BY_HAND = """\
<?xml version="1.0" encoding="UTF-8"?>
<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "http://www.w3.org/Graphics/SVG/1.1/DTD/svg11.dtd"
 [ <!ENTITY ns_svg "http://www.w3.org/2000/svg"> ]>
<svg xmlns="&ns_svg;" width="600px" height="400px" viewBox="0 0 600 400">
<style>.st0{{fill:none;stroke:#E3001B;stroke-width:2;}} .ax{{fill:none;stroke:#000}} .lb{{font-size:12px}}</style>
<g transform="translate(60 20)">
<rect class="ax" width="500" height="300"/>
<path stroke="#ccc" d="M0 0V300M100 0V300M200 0V300M300 0V300M400 0V300M500 0V300"/>
<path stroke="#ccc" d="M0 0H500M0 100H500M0 200H500M0 300H500"/>
<g class="lb" text-anchor="middle">{x}</g>
<g class="lb" text-anchor="end">{y}</g>
<g transform="scale(.5)"><path class="st0" d="{curve}"/></g>
{rest}</g></svg>
"""


def by_hand(path, *, x=("0.01", "0.1", "1", "10", "100", "1000"), y=("1", "10", "100", "1 000"), curve=None, rest=""):
    """Write `BY_HAND` with labels of the axes, whose decades are 100 units long."""
    if curve is None:
        tau = np.geomspace(0.01, 1000, 30)
        points = np.stack([200 * (np.log10(tau) + 2), 600 - 200 * np.log10(DEGREES_PER_HOUR * deviation(tau))], axis=1)
        slopes = np.gradient(points, axis=0) / 3
        curve = "M{:.2f} {:.2f}".format(*points[0])
        for k in range(len(points) - 1):
            step = points[k + 1] - points[k]
            cells = (*slopes[k], *(step - slopes[k + 1]), *step)
            curve += "c" + ",".join(f"{cell:.2f}" for cell in cells)
    labels = "".join(f'<text x="{100 * k}" y="316">{label}</text>' for k, label in enumerate(x))
    columns = "".join(f'<text x="-6" y="{304 - 100 * k}">{label}</text>' for k, label in enumerate(y))
    path.write_text(BY_HAND.format(x=labels, y=columns, curve=curve, rest=rest))
    return path


def pdf_file(content, *, trailer=b"", page=b"", further=()):
    """A PDF file with a page of this content."""
    objects = [
        b"<</Type/Catalog/Pages 2 0 R>>",
        b"<</Type/Pages/Kids[3 0 R]/Count 1>>",
        b"<</Type/Page/Parent 2 0 R/MediaBox[0 0 600 400]/Contents 4 0 R%s>>" % page,
        b"<</Length %d>>stream\n%s\nendstream" % (len(content), content),
        *further,
    ]
    data, places = b"%PDF-1.4\n", []
    for k, body in enumerate(objects, 1):
        places.append(len(data))
        data += b"%d 0 obj\n%s\nendobj\n" % (k, body)
    table = b"".join(b"%010d 00000 n \n" % place for place in places)
    end = b"trailer<</Root 1 0 R/Size %d%s>>\nstartxref\n%d\n%%%%EOF" % (len(objects) + 1, trailer, len(data))
    return data + b"xref\n0 %d\n0000000000 65535 f \n%s" % (len(objects) + 1, table) + end
