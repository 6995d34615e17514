"""Every public name has a docstring that says what it takes, gives and raises; `public_names` says which names are public.

The mechanical rules are those of numpydoc's validation that help a reader: sections in order (GL07), a summary with a full
stop (SS03), exactly the parameters of the signature in their order, each with a type and a text (PR01, PR02, PR03, PR04,
PR07), what is returned (RT01), See Also and Examples (SA01, EX01) of names that a user calls. The other codes are off: they
want an extended summary, a verb, a capital or a full stop everywhere (ES01, SS05, SS06, PR08, PR09, RT03, RT05, SA03), or
the text on a second line (GL01), which this package does not do. A method without parameters may say in its summary what it
returns; parameters may be those of another function that describes them; fields of a dataclass are under Attributes.
Beyond numpydoc, arrays have a shape, numbers a unit, estimators a source; `test_documented_errors` provokes the errors.
"""

import ast
import contextlib
import importlib
import inspect
import re
import sys
import textwrap
from dataclasses import fields
from functools import cache

import sigmatau
from docstring_sections import Sections, wanting
from public_names import (
    data_imported_by_pages,
    exported,
    function_of,
    imported_by_pages,
    is_protocol,
    kinds,
    public,
    public_fields,
    public_functions,
)

# Estimators, models and tests: a reader can look their formulas up.
SOURCED = (
    *(
        "Accumulator",
        "GaussMarkov",
        "LowPass",
        "Resonance",
        "Sinusoid",
        "allan",
        "arma",
        "avar_from_psd",
        "compare_with",
        "cross_spectrum",
    ),
    *(
        "deviation",
        "dynamic_allan",
        "fit",
        "fit_channel",
        "fit_jointly",
        "fit_slope",
        "judge_lot",
        "plan",
        "predict",
        "psd",
    ),
    *("random_effects", "read_off", "simulate", "simulate_to", "state_space", "transfer", "verify"),
    *("sigmatau.noise.terms.avar", "sigmatau.noise.terms.psd", "sigmatau.noise.uncertainty.degrees_of_freedom"),
    *("sigmatau.noise.uncertainty.percentage_error",),
    *("ChannelModel.avar", "ChannelModel.psd", "ChannelModel.autocovariance"),
)
ORDER = ("Parameters", "Attributes", "Returns", "Yields", "Raises", "See Also", "Notes", "References", "Examples")
SOURCE = re.compile(r":doi:|NIST|IEEE|ISO|JCGM|eqs?\. \(\d|\b(19|20)\d\d\b|docs/(theory|study)")


def classes():
    return {name: one for name, one in public().items() if inspect.isclass(one)}


def called():
    """What a user calls by its name, for which a docstring has an example and leads on."""
    return {**exported(), **{name: one for name, one in imported_by_pages().items() if callable(one)}}


def docstring(found):
    own = function_of(found) if not inspect.isclass(found) else None
    return Sections((own or found).__doc__)


def parameters(function):
    names = inspect.signature(function).parameters.values()
    return {one.name: str(one.annotation) for one in names if one.name not in ("self", "cls")}


def problems_of_entries(sections, section, expected):
    """What is wrong with a section that has to describe `expected`, annotations by name, and nothing else."""
    described = sections.described(section)
    found = [f"{section}: {name} is not described" for name in expected if name not in described]
    found += [f"{section}: {name} does not exist" for name in described if name not in expected]
    if section == "Parameters" and not found and list(described) != list(expected):
        found.append(f"{section}: not in the order of the signature")
    for name, annotation in expected.items():
        if name not in described:
            continue
        entry = described[name]
        referred = re.search(r"\b(?:See|As|As in|As for|In place of)\b[^`]*`(?:sigmatau\.)?([\w.]+)`", entry.text)
        if referred and describes(referred[1], name):
            continue
        if not entry.type:
            found.append(f"{section}: {name} has no type")
        found += [f"{section}: {name} lacks its {what}" for what in wanting(annotation, entry.type, entry.text)]
        if section == "Parameters" and not entry.text and not entry.type.startswith("{"):
            found.append(f"{section}: {name} has no text")
    return found


@cache
def describes(other, parameter):
    """Whether another public function, or method of the same or a public class, describes the parameter."""
    ends = [member for name, (_, member) in public_functions().items() if name == other or name.endswith(f".{other}")]
    return any(parameter in docstring(one).described("Parameters") for one in ends)


def problems_of_form(sections):
    if not sections.summary.endswith((".", "]", ":")):
        yield "no summary that ends with a full stop"
    if not sections.underlined:
        yield "an underline is not as long as its heading"
    if [name for name in ORDER if name in sections.by_name] != list(sections.by_name):
        yield f"unknown sections, or not in this order: {', '.join(ORDER)}"


def raised_in(function):
    """Names of the errors that the function itself raises."""
    tree = ast.parse(textwrap.dedent(inspect.getsource(function)))
    calls = [node.exc.func for node in ast.walk(tree) if isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call)]
    names = {call.id for call in calls if isinstance(call, ast.Name)}
    return {name for name in names if name[0].isupper() and name != "NotImplementedError"}


def test_the_surface_is_complete():
    """A page that imports from a new module, or a new result class, makes new public names by itself."""
    assert len(exported()) >= 67
    assert {"sigmatau.noise.terms.avar", "sigmatau.units.to_si"} <= set(imported_by_pages())
    assert {"sigmatau.fitting.fitted_values.FittedTerm", "sigmatau.statespace.arma.Arma"} <= set(public())
    assert {"Curves.plot", "sigmatau.results.Tabular.columns"} <= {
        *public_functions(),
        "sigmatau.results.Tabular.columns",
    }


def problems_of_class(name, found):
    sections = docstring(found)
    yield from problems_of_form(sections)
    fields = public_fields(found)
    if fields:
        annotations = {field: str(owner.__annotations__[field]) for field, owner in fields.items()}
        yield from problems_of_entries(sections, "Attributes", annotations)
    elif "__init__" in vars(found) and not is_protocol(found):
        yield from problems_of_entries(sections, "Parameters", parameters(found.__init__))
    if name in called():
        yield from (f"no {section}" for section in ("Examples", "See Also") if section not in sections)


def test_classes():
    problems = [f"{name}: {problem}" for name, cls in classes().items() for problem in problems_of_class(name, cls)]
    assert not problems, "\n".join(problems)


def problems_of_function(name, owner, function):
    sections = docstring(function)
    returned = str(inspect.signature(function).return_annotation)
    taken = parameters(function)
    yield from problems_of_form(sections)
    yield from problems_of_entries(sections, "Parameters", taken)
    if returned != "None" and (taken or owner is None):
        if "Returns" not in sections and "Yields" not in sections:
            yield "no Returns"
        else:
            entries = sections.entries("Returns") or sections.entries("Yields")
            told = " ".join(f"{' '.join(entry.names)} {entry.type} {entry.text}" for entry in entries)
            yield from (f"Returns lacks its {what}" for what in wanting(returned, "", told))
    elif returned != "None":
        yield from (f"what is returned lacks its {what}" for what in wanting(returned, "", sections.text))
    raised = {one for entry in sections.entries("Raises") for one in entry.names}
    yield from (f"Raises: {error} is not told" for error in raised_in(function) if error not in raised)
    if name in called():
        yield from (f"no {section}" for section in ("Examples", "See Also") if section not in sections)


def test_functions():
    problems = [
        f"{name}: {problem}"
        for name, (owner, member) in public_functions().items()
        for problem in problems_of_function(name, owner, function_of(member))
    ]
    assert not problems, "\n".join(problems)


def test_sources():
    for name in SOURCED:
        found = public()[name] if name in public() else public_functions()[name][1]
        assert SOURCE.search("\n".join(docstring(found).by_name.get("References", ()))), f"{name}: no source"


def found_in(places, names):
    """Whether the first place that has the first name leads to the others, attribute by attribute."""
    place = next((place for place in places if hasattr(place, names[0])), None)
    for name in names:
        if not hasattr(place, name):
            return name in getattr(place, "__annotations__", {})
        place = getattr(place, name)
    return True


def leads_somewhere(name, module, owner):
    """Whether a name in a docstring exists: with the package in front, in the class, in the module, or in sigmatau."""
    if not name.startswith("sigmatau."):
        return found_in((owner, sys.modules[module], sigmatau), name.split("."))
    with contextlib.suppress(ImportError):
        return importlib.import_module(name) is not None
    above, _, last = name.rpartition(".")
    with contextlib.suppress(ImportError):
        return found_in((importlib.import_module(above),), [last])
    above, _, of = above.rpartition(".")
    return found_in((importlib.import_module(above),), [of, last])


def test_names_in_docstrings_exist():
    """See Also, and names with a dot in backticks; others may be parameters."""
    every = [(name, one, one if inspect.isclass(one) else None) for name, one in public().items()]
    every += [(name, function_of(member), owner) for name, (owner, member) in public_functions().items()]
    missing = []
    for name, one, owner in every:
        sections = docstring(one)
        named = {other for entry in sections.entries("See Also") for other in entry.names}
        named |= set(re.findall(r"(?<!`)`((?:\w+\.)+\w+)`(?!`)", sections.text)) - {"scipy.signal.sosfilt"}
        missing += [f"{name}: {other}" for other in named if not leads_somewhere(other, one.__module__, owner)]
    assert not missing, "\n".join(missing)


def test_constants():
    """A constant that a page imports has a docstring below it, which documentation tools show."""
    for module, name in data_imported_by_pages():
        body = ast.parse(inspect.getsource(sys.modules[module])).body
        (at,) = (
            k
            for k, node in enumerate(body)
            if isinstance(node, ast.Assign | ast.AnnAssign)
            and name in ast.unparse(node).partition("=")[0].split(":")[0]
        )
        below = body[at + 1]
        assert isinstance(below, ast.Expr), f"{module}.{name}"
        assert str(ast.literal_eval(below.value)).endswith("."), f"{module}.{name}"


def problems_of_kind(kind):
    sections = docstring(kind)
    yield from problems_of_form(sections)
    constant = {field.name for field in fields(kind) if not field.init}  # the kind of a reason
    annotations = {name: str(of) for name, of in vars(kind).get("__annotations__", {}).items() if name not in constant}
    own = {name: of for name, of in annotations.items() if not of.startswith("ClassVar")}
    yield from problems_of_entries(sections, "Attributes", own)


def test_kinds_of_findings():
    """The parameters of a finding are public as data: ``finding.details``, and ``details`` in JSON."""
    problems = [f"{kind.__name__}: {problem}" for kind in kinds() for problem in problems_of_kind(kind)]
    assert not problems, "\n".join(problems)
