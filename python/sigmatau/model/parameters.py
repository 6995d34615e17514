"""Parameters of a model and their covariance."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import field
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from sigmatau.arrays import Floats
from sigmatau.decoding import key
from sigmatau.frozen import frozen
from sigmatau.results import plain

Quantity = Literal["sigma", "time", "frequency", "width", "amplitude"]


@frozen(kw_only=False)
class Parameter:
    """A parameter of a model: the coefficient of a term, or a parameter of a process.

    Attributes
    ----------
    part : str
        A key of `sigmatau.noise.terms.TERMS`, ``"gauss_markov"``, ``"resonance"`` or ``"sinusoid"``.
    number : int or None
        Place of a process among those of its kind, from 1; None for a term.
    quantity : {"sigma", "time", "frequency", "width", "amplitude"} or None
        The parameter of a process; None for a term.
    """

    part: str
    number: int | None = key("place of a process among those of its kind", default=None, always=True, null=True)
    quantity: Quantity | None = key("number of a process", default=None, always=True, null=True)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Parameter) and (self.part, self.number, self.quantity) == (
            other.part,
            other.number,
            other.quantity,
        )

    def __hash__(self) -> int:
        return hash((self.part, self.number, self.quantity))

    @classmethod
    def of(cls, name: str) -> Parameter:
        """The parameter with a name.

        Parameters
        ----------
        name : str
            The name in JSON. Any other text becomes a parameter whose part is that text.

        Returns
        -------
        Parameter
        """
        process, _, quantity = name.partition(".")
        part, _, number = process.rpartition("_")
        if quantity in ("sigma", "time", "frequency", "width", "amplitude") and number.isdecimal():
            return cls(part, int(number), quantity)  # type: ignore[arg-type]  # mypy does not narrow by `in`
        return cls(name)

    @property
    def name(self) -> str:
        """Name in JSON: ``"random_walk"``, ``"gauss_markov_1.time"``."""
        return self.part if self.quantity is None else f"{self.part}_{self.number}.{self.quantity}"

    def to_dict(self) -> dict[str, Any]:
        """Plain values."""
        return plain(self, "part number quantity")


@frozen(eq=False)
class Covariance:
    """Covariance of parameters of a model.

    Attributes
    ----------
    parameters : tuple of Parameter
        Rows of the matrix.
    matrix : ndarray, shape (n, n)
        [SI]

    Examples
    --------
    >>> from sigmatau.model.parameters import Covariance, Parameter
    >>> covariance = Covariance.of(["random_walk", "gauss_markov_1.time"], [[1e-12, 0.0], [0.0, 9.0]])
    >>> covariance.variance_of(Parameter("gauss_markov", 1, "time"))
    9.0
    >>> covariance.names
    ('random_walk', 'gauss_markov_1.time')
    """

    parameters: tuple[Parameter, ...] = ()
    matrix: Floats = field(default_factory=lambda: np.empty((0, 0)))

    @classmethod
    def of(cls, names: Sequence[str], matrix: ArrayLike) -> Covariance:
        """The covariance of parameters that are given by name.

        Parameters
        ----------
        names : sequence of str
            As in JSON, see `Parameter.name`.
        matrix : array_like, shape (n, n)
            [SI]

        Returns
        -------
        Covariance
        """
        square = np.asarray(matrix, dtype=np.float64).reshape((len(names),) * 2)
        return cls(parameters=tuple(Parameter.of(name) for name in names), matrix=square)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters in JSON."""
        return tuple(parameter.name for parameter in self.parameters)

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI."""
        return {"terms": list(self.names), "matrix": self.matrix.tolist()}

    def variance_of(self, parameter: Parameter) -> float | None:
        """Variance of a parameter.

        Parameters
        ----------
        parameter : Parameter
            The parameter.

        Returns
        -------
        float or None
            None if it is not in the covariance. [SI]
        """
        if parameter not in self.parameters:
            return None
        row = self.parameters.index(parameter)
        return float(self.matrix[row, row])

    def select(self, renamed: Callable[[Parameter], Parameter | None]) -> Covariance:
        """The covariance of some of the parameters.

        Parameters
        ----------
        renamed : callable
            Returns, for each parameter, its counterpart in the new covariance, or None to leave it out.

        Returns
        -------
        Covariance
        """
        chosen = [(k, new) for k, parameter in enumerate(self.parameters) if (new := renamed(parameter)) is not None]
        rows = [k for k, _ in chosen]
        return Covariance(parameters=tuple(new for _, new in chosen), matrix=self.matrix[np.ix_(rows, rows)])

    def scaled(self, factors: Mapping[Parameter, float]) -> Covariance:
        """The covariance with other standard errors of some parameters.

        Parameters
        ----------
        factors : mapping of Parameter to float
            New standard error over that in this covariance; 1 for all others. [1]

        Returns
        -------
        Covariance
        """
        scale = np.array([factors.get(parameter, 1.0) for parameter in self.parameters])
        return Covariance(parameters=self.parameters, matrix=self.matrix * np.outer(scale, scale))
