"""The hand-written stub says what the package is."""

import ast
import inspect
from pathlib import Path

import chladni

STUB = ast.parse((Path(chladni.__file__).parent / "__init__.pyi").read_text())


def parameters(function):
    a = function.args
    names = [p.arg for p in [*a.posonlyargs, *a.args, *a.kwonlyargs]]
    defaults = [None] * (len(a.args) - len(a.defaults)) + a.defaults + a.kw_defaults
    return [(n, None if d is None else ast.literal_eval(d)) for n, d in zip(names, defaults, strict=True)]


def test_the_stub_has_every_name_and_every_argument():
    stubbed = {node.name: node for node in STUB.body if isinstance(node, ast.FunctionDef | ast.ClassDef)}
    assert set(stubbed) == set(chladni.__all__)
    assert (Path(chladni.__file__).parent / "py.typed").exists()
    for name, node in stubbed.items():
        real = getattr(chladni, name)
        if isinstance(node, ast.FunctionDef):
            found = [
                (p.name, None if p.default is p.empty else p.default)
                for p in inspect.signature(real).parameters.values()
            ]
            assert parameters(node) == found, name
        else:
            is_dataclass = any("dataclass" in ast.dump(d) for d in node.decorator_list)
            assert is_dataclass == hasattr(real, "__dataclass_fields__"), name
            assert [base.id for base in node.bases] in ([], [base.__name__ for base in real.__bases__])
            fields = getattr(real, "__dataclass_fields__", {})
            for member in node.body:
                if isinstance(member, ast.FunctionDef):
                    assert hasattr(real, member.name), (name, member.name)
                elif isinstance(member, ast.AnnAssign):
                    assert member.target.id in fields, (name, member.target.id)
