"""Maximum likelihood of covariance matrices by component, from the bands of several channels.

y_k ~ N(0, S_k), S_k = Σ_t s_t(k)·C_t, C_t = Σ_p θ_tp·E_p. A constant and the regressors of the mean are eliminated by the
restricted likelihood. Either C_t is any positive semidefinite matrix and the E_p select its elements, or the E_p are given
matrices and their coefficients are not negative.

References
----------
.. [1] D. A. Harville, "Maximum likelihood approaches to variance component estimation and to related problems," J. Am.
   Stat. Assoc., vol. 72, 1977, :doi:`10.1080/01621459.1977.10480998`.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from sigmatau.arrays import Floats
from sigmatau.frozen import frozen
from sigmatau.lab.arrays.cosine_bands import Bands

_STEPS = 100  # largest number of steps; a dozen are usual
# Increase of the log-likelihood below which the search ends. [1] Derived: changes an estimate by 0.014 standard errors.
_TOLERANCE = 1e-4
_FULL_STEP = 1e-2  # damping below which a step is nearly undamped [1]
_ZERO = 1e-4  # ratio of a coefficient or an eigenvalue to the mean, below which it counts as 0 [1]
_NUDGE = 0.01  # share of the mean variance that is added to a component before a restart [1]
_PROFILE_TOLERANCE = 1e-2  # tolerance of the log-likelihood in a profile, whose threshold is 3.8 [1]
_RIDGE = 1e-9  # share of the trace that is added to a matrix before its Cholesky decomposition [1]
_DAMPING = (1e-3, 1e8)  # first damping of a step, and the one at which the search ends [1]


@frozen(eq=False)
class Structure:
    """The matrices E_p, of which each C_t is a linear combination.

    Attributes
    ----------
    elements : ndarray, shape (n_parameters, n, n)
        Symmetric matrices E_p.
    semidefinite : bool
        Whether C_t is any positive semidefinite matrix; otherwise its coefficients are at least 0.
    """

    elements: Floats
    semidefinite: bool


@frozen(eq=False)
class CovarianceFit:
    """Estimated coefficients θ with their covariance, and the state from which profiles start.

    Attributes
    ----------
    theta : ndarray, shape (n_components, n_parameters)
    covariance : ndarray, shape (n_components·n_parameters, n_components·n_parameters)
        Inverse of the Fisher information.
    structure : Structure
    densities : ndarray, shape (n_components, n_bands)
    bands : Bands
    residual : ndarray, shape (n_bands, n, n)
        Sums of squares without the mean, corrected for the expectation that its estimation removes.
    log_likelihood : float
    problem : ScaledProblem
    root : ndarray, shape (n_components, n_roots)
        Scaled roots of the coefficients.
    """

    theta: Floats
    covariance: Floats
    structure: Structure
    densities: Floats
    bands: Bands
    residual: Floats
    log_likelihood: float
    problem: ScaledProblem
    root: Floats

    @property
    def matrices(self) -> Floats:
        """The C_t, shape (n_components, n, n)."""
        return np.asarray(np.einsum("tp,pij->tij", self.theta, self.structure.elements))

    @property
    def spectra(self) -> Floats:
        """The S of each band, shape (n_bands, n, n)."""
        return np.asarray(np.einsum("tb,tij->bij", self.densities, self.matrices))

    def component_covariance(self, t: int) -> Floats:
        """Covariance of the coefficients of a component, shape (n_parameters, n_parameters)."""
        size = self.theta.shape[1]
        rows = slice(t * size, (t + 1) * size)
        return self.covariance[rows, rows]


@lru_cache(maxsize=8)
def full_structure(n: int) -> Structure:
    """All symmetric matrices: the parameters are the lower triangle, row by row."""
    rows, columns = np.tril_indices(n)
    elements = np.zeros((len(rows), n, n))
    elements[np.arange(len(rows)), rows, columns] = 1.0
    elements[np.arange(len(rows)), columns, rows] = 1.0
    return Structure(elements=elements, semidefinite=True)


def diagonal_structure(contrasts: Floats) -> Structure:
    """Structure of contrasts of independent channels; the contrasts are the columns of a matrix, shape (n, n_contrasts)."""
    return Structure(elements=np.einsum("ia,ib->iab", contrasts, contrasts), semidefinite=False)


@frozen(eq=False)
class ScaledProblem:
    """Bands and densities scaled to numbers near 1, for the search.

    Attributes
    ----------
    bands : Bands
    densities : ndarray, shape (n_components, n_bands)
    structure : Structure
    scale : ndarray, shape (n,)
        Divisors of the channels. [unit]
    weights : ndarray, shape (n_components,)
        Divisors of the densities.
    """

    bands: Bands
    densities: Floats
    structure: Structure
    scale: Floats
    weights: Floats

    @property
    def factors(self) -> Floats:
        """Factors of the scaled coefficients, shape (n_components, n_parameters)."""
        if self.structure.semidefinite:
            rows, columns = np.tril_indices(len(self.scale))
            outer = self.scale[rows] * self.scale[columns]
        else:
            outer = np.full(len(self.structure.elements), self.scale[0] ** 2)
        return np.asarray(outer[None, :] / self.weights[:, None])

    @property
    def constant(self) -> float:
        """Constant that converts the log-likelihood of the scaled channels to that of the channels."""
        frequencies = float(self.bands.count.sum()) - self.bands.trends.shape[1]
        return float(-frequencies * np.log(self.scale).sum())

    def maximise(self, root: Floats, fixed: int | None = None, tolerance: float = _TOLERANCE) -> tuple[Floats, _State]:
        """Maximise the likelihood, from the roots `root` on; the root with the index `fixed` does not change."""
        theta, jacobian = _expand_root(self.structure, root)
        state, damping = _evaluate(self, theta), _DAMPING[0]
        free = np.delete(np.arange(root.size), [] if fixed is None else fixed)
        for _ in range(_STEPS):
            score, information = _derivatives(self, state)
            gradient = np.einsum("tp,tpr->tr", score, jacobian).ravel()[free]
            block = _blocks(jacobian)[:, free]
            inner = block.T @ information @ block + _curvature(self.structure, score)[np.ix_(free, free)]
            better = self._step(root, gradient, inner, damping, state.log_likelihood, free)
            if better is None:
                break
            gain = better[1].log_likelihood - state.log_likelihood
            root, state, damping = better[0], better[1], max(better[2] / 10, 1e-9)
            _, jacobian = _expand_root(self.structure, root)
            if gain < tolerance and damping <= _FULL_STEP:
                break
        return root, state

    def _step(
        self, root: Floats, gradient: Floats, information: Floats, damping: float, before: float, free: np.ndarray
    ) -> tuple[Floats, _State, float] | None:
        """A damped step that raises the likelihood; None if no step does."""
        diagonal = np.diag(np.maximum(np.diag(information), 1e-12 * np.diag(information).max()))
        while damping < _DAMPING[1]:
            step = np.zeros(root.size)
            step[free] = np.linalg.solve(information + damping * diagonal, gradient)
            new = root + step.reshape(root.shape)
            state = _evaluate(self, _expand_root(self.structure, new)[0])
            if state.log_likelihood >= before:
                return new, state, damping
            damping = 10 * max(damping, 1e-4)
        return None


def fit_covariance(bands: Bands, densities: Floats, structure: Structure, first: Floats) -> CovarianceFit:
    """Maximise the restricted likelihood by Fisher scoring in the roots of the coefficients.

    `densities`: shape (n_components, samples); `first`: variances from which the search starts, shape (n_components, n) for
    a full structure, otherwise (n_components, n_parameters).
    """
    shapes = np.stack([bands.mean(density) for density in densities])
    size = np.mean(np.einsum("tb,ti->bi", shapes, first), axis=0)
    scale = np.sqrt(size) if structure.semidefinite else np.full(bands.power.shape[1], np.sqrt(size.mean()))
    weights = shapes.mean(axis=1)
    problem = ScaledProblem(
        bands=bands.combined(np.diag(1 / scale)),
        densities=shapes / weights[:, None],
        structure=structure,
        scale=scale,
        weights=weights,
    )
    values = first * weights[:, None] / (scale**2 if structure.semidefinite else scale[0] ** 2)
    root, state = problem.maximise(_first_root(structure, values))
    if _has_zeros(
        structure, root
    ):  # the gradient by a root that is 0 vanishes, even if that by its coefficient does not
        new_root, new_state = problem.maximise(_without_zeros(structure, root))
        if new_state.log_likelihood > state.log_likelihood:
            root, state = new_root, new_state
    factors = problem.factors
    return CovarianceFit(
        theta=_expand_root(structure, root)[0] * factors,
        covariance=_inverse(_derivatives(problem, state)[1]) * np.outer(factors.ravel(), factors.ravel()),
        structure=structure,
        densities=shapes,
        bands=bands,
        residual=state.residual * np.outer(scale, scale),
        log_likelihood=state.log_likelihood + problem.constant,
        problem=problem,
        root=root,
    )


@frozen(eq=False)
class _State:
    """Restricted likelihood for some coefficients, and matrices from which its derivatives are computed."""

    log_likelihood: float
    inverse: Floats
    residual: Floats
    lost: Floats  # expectation of the sums of squares that the estimation of the mean removes
    spectra: Floats


def _blocks(jacobian: Floats) -> Floats:
    """Derivative of all coefficients by all roots: a block-diagonal matrix with a block for each component."""
    count, size, width = jacobian.shape
    block = np.zeros((count, size, count, width))
    block[np.arange(count), :, np.arange(count)] = jacobian
    return block.reshape(count * size, count * width)


def _first_root(structure: Structure, first: Floats) -> Floats:
    """Roots from which the search starts: diagonal factors for matrices, square roots for coefficients."""
    if not structure.semidefinite:
        return np.sqrt(first)
    rows, columns = np.tril_indices(first.shape[1])
    root = np.zeros((len(first), len(rows)))
    root[:, rows == columns] = np.sqrt(first)
    return root


def _has_zeros(structure: Structure, root: Floats) -> bool:
    """Whether a coefficient is 0, or a matrix is singular."""
    theta, _ = _expand_root(structure, root)
    values = theta
    if structure.semidefinite:
        values = np.linalg.eigvalsh(np.einsum("tp,pij->tij", theta, structure.elements))
    return bool((values < _ZERO * values.mean(axis=1, keepdims=True)).any())


def _without_zeros(structure: Structure, root: Floats) -> Floats:
    """Roots of slightly larger coefficients, none of which is 0."""
    theta, _ = _expand_root(structure, root)
    if not structure.semidefinite:
        return np.asarray(np.sqrt(theta + _NUDGE * theta.mean(axis=1, keepdims=True) + 1e-12))
    n = structure.elements.shape[1]
    rows, columns = np.tril_indices(n)
    matrices = np.einsum("tp,pij->tij", theta, structure.elements)
    size = np.einsum("tii->t", matrices)[:, None, None] / n
    return np.asarray(np.linalg.cholesky(matrices + (_NUDGE * size + 1e-12) * np.eye(n))[:, rows, columns])


def _expand_root(structure: Structure, root: Floats) -> tuple[Floats, Floats]:
    """Coefficients θ of some roots, and the derivative of θ, shape (n_components, n_parameters, n_roots)."""
    if not structure.semidefinite:
        return root**2, 2 * root[:, :, None] * np.eye(root.shape[1])
    n = structure.elements.shape[1]
    rows, columns = np.tril_indices(n)
    factor = np.zeros((len(root), n, n))
    factor[:, rows, columns] = root
    theta = np.einsum("tik,tjk->tij", factor, factor)[:, rows, columns]
    # d(LLᵀ)_ij/dL_rc = δ_ir·L_jc + L_ic·δ_jr
    jacobian = (rows[:, None] == rows[None, :]) * factor[:, columns[:, None], columns[None, :]]
    jacobian = jacobian + (columns[:, None] == rows[None, :]) * factor[:, rows[:, None], columns[None, :]]
    return theta, jacobian


def _curvature(structure: Structure, score: Floats) -> Floats:
    """Part of the second derivative of -log L by the roots that comes from θ being quadratic in them.

    Only its positive part is used, which belongs to coefficients that the step reduces. Without it, steps towards 0 are
    much too long.
    """
    count, width = score.shape
    if not structure.semidefinite:
        return np.diag(np.maximum(-2 * score.ravel(), 0.0))
    n = structure.elements.shape[1]
    rows, columns = np.tril_indices(n)
    gradients = np.zeros((count, n, n))
    gradients[:, rows, columns] = gradients[:, columns, rows] = -0.5 * score * (1 + (rows == columns))
    values, vectors = np.linalg.eigh(gradients)
    positive = (vectors * np.maximum(values, 0.0)[:, None, :]) @ vectors.transpose(0, 2, 1)
    same_column = columns[:, None] == columns[None, :]
    result = np.zeros((count, width, count, width))
    result[np.arange(count), :, np.arange(count)] = 2 * positive[:, rows[:, None], rows[None, :]] * same_column
    return result.reshape(count * width, count * width)


def _evaluate(problem: ScaledProblem, theta: Floats) -> _State:
    """Restricted log-likelihood; ref. [1]."""
    bands = problem.bands
    n, q = bands.power.shape[1], bands.trends.shape[1]
    flat = problem.structure.elements.reshape(-1, n * n)
    spectra = (problem.densities.T @ theta @ flat).reshape(-1, n, n)
    sign, logarithm = np.linalg.slogdet(spectra)
    if not (sign > 0).all():
        return _State(log_likelihood=-np.inf, inverse=spectra, residual=bands.power, lost=bands.power, spectra=spectra)
    inverse: Floats = np.asarray(np.linalg.inv(spectra), dtype=np.float64)
    count = len(inverse)
    by_regressors = (bands.trends.reshape(count, q * q).T @ inverse.reshape(count, n * n)).reshape(q, q, n, n)
    normal = by_regressors.transpose(0, 2, 1, 3).reshape(q * n, q * n)
    right = (bands.trend @ inverse).sum(axis=0).ravel()
    variance = np.linalg.inv(normal)
    slopes = (variance @ right).reshape(q, n)
    by_pair = variance.reshape(q, n, q, n).transpose(0, 2, 1, 3).reshape(q * q, n * n)
    lost = (bands.trends.reshape(count, q * q) @ by_pair).reshape(count, n, n)
    crossed = bands.trend.transpose(0, 2, 1) @ slopes
    squares = bands.power - crossed - crossed.transpose(0, 2, 1) + slopes.T @ bands.trends @ slopes
    likelihood = -0.5 * float(bands.count @ logarithm + np.vdot(inverse, squares) + np.linalg.slogdet(normal)[1])
    return _State(log_likelihood=likelihood, inverse=inverse, residual=squares + lost, lost=lost, spectra=spectra)


def _derivatives(problem: ScaledProblem, state: _State) -> tuple[Floats, Floats]:
    """Derivative of the log-likelihood by the coefficients, shape (n_components, n_parameters), and the information."""
    bands, shapes, inverse = problem.bands, problem.densities, state.inverse
    n = inverse.shape[1]
    flat = problem.structure.elements.reshape(-1, n * n)
    count = bands.count[:, None, None]
    excess = inverse @ (state.residual - count * state.spectra) @ inverse
    score = 0.5 * shapes @ excess.reshape(-1, n * n) @ flat.T
    projected = inverse - inverse @ (state.lost / count) @ inverse
    kron = (projected[:, :, None, :, None] * projected[:, None, :, None, :]).reshape(-1, n * n, n * n)
    products = 0.5 * count * (flat @ kron @ flat.T)
    size, parameters = len(shapes), len(flat)
    weights = (shapes[:, None, :] * shapes[None, :, :]).reshape(size * size, -1)
    information = (weights @ products.reshape(len(products), -1)).reshape(size, size, parameters, parameters)
    return score, information.transpose(0, 2, 1, 3).reshape(size * parameters, size * parameters)


def _inverse(information: Floats) -> Floats:
    """Inverse of the information, scaled to a unit diagonal first."""
    scale = 1 / np.sqrt(np.maximum(np.diag(information), 1e-300))
    return np.asarray(np.linalg.pinv(information * np.outer(scale, scale), hermitian=True) * np.outer(scale, scale))


class Profile:
    """Likelihood as a function of one variance, with all other coefficients free.

    Parameters
    ----------
    fit : CovarianceFit
    t : int
        Component.
    p : int
        Index of a channel, for a full structure, or of a parameter.
    """

    __slots__ = ("_fit", "_problem", "_root", "_root_index", "_t")

    def __init__(self, fit: CovarianceFit, t: int, p: int) -> None:
        problem, root, root_index = fit.problem, fit.root, p
        if (
            fit.structure.semidefinite
        ):  # the channel is moved to the first place, so that its variance is the square of a single root
            n = len(problem.scale)
            order = np.array([p, *(k for k in range(n) if k != p)])
            rows, columns = np.tril_indices(n)
            theta = _expand_root(problem.structure, root)[0]
            matrices = np.einsum("tp,pij->tij", theta, problem.structure.elements)[:, order][:, :, order]
            matrices = matrices + _RIDGE * np.eye(n) * np.einsum("tii->t", matrices)[:, None, None]
            root = np.linalg.cholesky(matrices)[:, rows, columns]
            problem = replace(problem, bands=problem.bands.combined(np.eye(n)[:, order]), scale=problem.scale[order])
            root_index = 0
        self._fit, self._t, self._problem, self._root, self._root_index = fit, t, problem, root, root_index

    def loss(self, variance: float) -> float:
        """Twice the decrease of the log-likelihood if the variance has this value."""
        start = self._root.copy()
        start[self._t, self._root_index] = np.sqrt(
            max(variance, 0.0) / self._problem.factors[self._t, self._root_index]
        )
        fixed = self._t * start.shape[1] + self._root_index
        root, state = self._problem.maximise(start, fixed=fixed, tolerance=_PROFILE_TOLERANCE)
        if variance > 0:
            self._root = root
        return 2 * (self._fit.log_likelihood - state.log_likelihood - self._problem.constant)
