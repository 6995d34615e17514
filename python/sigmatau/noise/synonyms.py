"""Other names of the noise terms, from docs/glossary.md, for errors about unknown names."""

from __future__ import annotations

from collections.abc import Iterable

from sigmatau.noise.terms import TERMS

_MEANT = {name: term.name for term in TERMS.values() for name in term.synonyms.split(", ")}
_MEANT["q"] = "quantization (IEEE 952) or random_walk (the paper)"


def unknown_term(name: object, terms: Iterable[str] = TERMS) -> str:
    """Text for an unknown name of a term: the term that it means, or the list of terms."""
    meant = _MEANT.get(str(name).lower().replace("_", " ").replace("-", " "))
    return f"unknown term {name!r}; " + (f"it is {meant} here" if meant else f"terms: {', '.join(terms)}")
