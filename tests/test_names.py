"""Public names: the package's interface, its version, and annotations for tools."""

import importlib
import inspect
import typing
from importlib.metadata import version

import pytest
from modules import MODULES

import bobrossnet as bob


def test_the_package_lists_what_it_offers():
    assert sorted(dir(bob)) == sorted([*bob.__all__, "__version__"])
    assert all(hasattr(bob, name) for name in dir(bob))
    with pytest.raises(AttributeError, match="module 'bobrossnet' has no attribute 'nothing'"):
        bob.nothing  # noqa: B018


def test_the_version_is_the_installed_one():
    assert bob.__version__ == version("bobrossnet")


def public(module):
    """Return a module's public functions, classes and their methods."""
    for name, member in vars(module).items():
        if name.startswith("_") or getattr(member, "__module__", None) != module.__name__:
            continue
        if inspect.isfunction(member):
            yield member
        elif inspect.isclass(member):
            yield member
            yield from filter(inspect.isfunction, map(function_of, vars(member).values()))


def function_of(member):
    """Return the function of a property, a class method or a static method."""
    for attribute in ("fget", "func", "__func__"):
        member = getattr(member, attribute, member)
    return member


@pytest.mark.parametrize("name", ["bobrossnet._core", *MODULES])
def test_annotations_are_of_what_is_there(name):
    for member in public(importlib.import_module(name)):
        typing.get_type_hints(member)
