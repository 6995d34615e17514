"""Every error in the docstring of a public name is provoked, in each way that the docstring states.

`PROVOKED` has, by name and error, the calls that raise it. A Raises section without an entry here fails the test, and so
does an entry without a Raises section.
"""

import importlib

import pytest

import provoked_models
import provoked_records
import provoked_results
from docstring_sections import Sections
from public_names import function_of, public, public_functions

PROVOKED = provoked_models.PROVOKED | provoked_records.PROVOKED | provoked_results.PROVOKED


def errors_of(documented):
    return {error for entry in Sections(documented.__doc__).entries("Raises") for error in entry.names}


def test_every_error_that_is_told_is_provoked():
    documented = {**public(), **{name: function_of(member) for name, (_, member) in public_functions().items()}}
    for name in PROVOKED.keys() - documented.keys():  # of a module that pages may import from
        module, _, function = name.rpartition(".")
        documented[name] = getattr(importlib.import_module(module), function)
    told = {name: errors for name, one in documented.items() if (errors := errors_of(one))}
    assert {name: {error.__name__ for error in cases} for name, cases in PROVOKED.items()} == told


@pytest.mark.parametrize("name", PROVOKED)
def test_errors(name, tmp_path, monkeypatch):
    """Each call in an empty folder."""
    for error, calls in PROVOKED[name].items():
        for k, call in enumerate(calls):
            folder = tmp_path / f"{error.__name__}-{k}"
            folder.mkdir()
            monkeypatch.chdir(folder)
            with pytest.raises(error):
                call()
