"""Findings about curves, and about checks that were omitted."""

from __future__ import annotations

from sigmatau.findings.finding import Details, Finding, Words
from sigmatau.frozen import frozen
from sigmatau.hints import Hint
from sigmatau.results import duration_text, seconds


@frozen
class OutOfRange(Details, code="out_of_range"):
    """The Allan variances cannot be squared in double precision: the channel is not analysed.

    Attributes
    ----------
    largest : float
        Largest Allan deviation. [rate_unit]
    rate_unit : str
        SI unit of the channel.
    """

    largest: float
    rate_unit: str

    def words(self, finding: Finding) -> Words:
        size = "large" if self.largest > 1 else "small"
        return Words(
            f"Allan deviations up to {self.largest:.3g} {self.rate_unit} are too {size}; not analysed",
            "Check unit and scale",
        )


@frozen
class ConstantChannel(Details, code="constant_channel"):
    """The samples differ by no more than rounding: the channel is not analysed.

    Attributes
    ----------
    samples : int
        Samples in the record.
    value : float or None
        The first sample; None if only the curve is known. [rate_unit]
    rate_unit : str
        SI unit of the channel.
    """

    samples: int
    value: float | None = None
    rate_unit: str = ""

    def words(self, finding: Finding) -> Words:
        what = f"all {self.samples} samples are equal"
        if self.value is not None:
            what = f"{self.samples} samples of {self.value:.6g} {self.rate_unit} differ by no more than rounding"
        return Words(f"{what}; not analysed", "Check the wiring, the resolution and the column")


@frozen
class TooFewSamples(Details, code="too_few_samples"):
    """Too many samples are missing for an Allan variance: the channel is not analysed.

    Attributes
    ----------
    missing : int
        Samples that are missing.
    samples : int
        Samples in the record.
    """

    missing: int
    samples: int

    def words(self, finding: Finding) -> Words:
        return Words(f"{self.missing} of {self.samples} samples are missing; not analysed")


@frozen
class Strided(Details, code="strided"):
    """Long clusters do not begin at every sample.

    Attributes
    ----------
    tau : float
        Shortest averaging time of such clusters. [s]
    samples : int
        Length of the record.
    out_of_memory : bool
        Whether the record does not fit in memory; otherwise an option requested it.
    """

    tau: float
    samples: int
    out_of_memory: bool = False

    def words(self, finding: Finding) -> Words:
        why = f"{self.samples} samples do not fit in memory: " if self.out_of_memory else ""
        return Words(f"{why}from τ = {seconds(self.tau)} s, clusters start at every 64th sample or less often")


@frozen
class NoMap(Details, code="no_map"):
    """The record is too short for the dynamic Allan deviation.

    Attributes
    ----------
    samples : int
        Samples in the record.
    needed : int
        Samples that a map needs.
    """

    samples: int
    needed: int

    def words(self, finding: Finding) -> Words:
        return Words(f"no stability map: {self.samples} samples, at least {self.needed} are needed")


@frozen
class CheckedInPart(Details, code="checked_in_part"):
    """Only the beginning of a long record is checked for faults.

    Attributes
    ----------
    checked, samples : int
        Samples that are checked, and all.
    duration : float
        Duration of the samples that are checked. [s]
    """

    checked: int
    samples: int
    duration: float

    def words(self, finding: Finding) -> Words:
        return Words(
            f"only the first {duration_text(self.duration)} are checked for faults, {self.checked} of"
            f" {self.samples} samples",
            f"Check another part with {Hint('window')}",
        )


@frozen
class CheckedWithoutFit(Details, code="checked_without_fit"):
    """The record is too long for a quick fit; the checks that need a fit are omitted.

    Attributes
    ----------
    samples : int
        Number of samples of all channels together.
    """

    samples: int

    def words(self, finding: Finding) -> Words:
        return Words(
            f"{self.samples} samples are too many for a quick fit: warm-up, temperature and changing noise not checked",
            "Run sigmatau analyze to check them",
        )


@frozen
class CurvesNotKept(Details, code="curves_not_kept"):
    """The result is from a store that did not keep the points of its Allan deviations. Coefficients are complete."""

    def words(self, finding: Finding) -> Words:
        return Words(
            "the Allan deviations of this result were not kept in the store",
            f"Analyse the log again to draw them, or to add them with {Hint('keep_curves', value='all')}",
        )
