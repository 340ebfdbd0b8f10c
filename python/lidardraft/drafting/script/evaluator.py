"""A script, carried out on values of ours. Nothing of it is ever run by Python."""

from __future__ import annotations

import ast
import gc

from lidardraft.drafting.script.frame import Frame
from lidardraft.drafting.script.generators import Generators, yielding_nodes
from lidardraft.drafting.script.limits import Limits, RaisedError, RefusalError
from lidardraft.drafting.script.modules import Annotations, RandomNumbers, math_module
from lidardraft.drafting.script.os_modules import SCRIPT
from lidardraft.drafting.script.outside import Outside
from lidardraft.drafting.script.source import parse
from lidardraft.drafting.script.standard_modules import standard_modules
from lidardraft.drafting.script.statements import Execute
from lidardraft.drafting.script.values import Namespace, Record, Value

_STEPS_OF_TOKEN = 6  # what parsing it takes
_STEPS_OF_WALK = 2  # what going once more through the tree takes, for a token


class Evaluator(Generators):
    """Reads scripts that may use `modules`: math, random, and what is added to them.

    `notes` are lines about what was passed over, each with the line of the script where that was met first.
    """

    def __init__(self, limits: Limits) -> None:
        super().__init__(limits)
        self.notes: dict[str, int] = {}
        self.modules: dict[str, Record] = {
            "math": math_module(self.budget),
            "random": RandomNumbers(self.budget, self.note),
            "typing": Annotations(),
            "__future__": Annotations(),
            **standard_modules(self.budget, self.call, self.note),
        }
        self.statements |= {ast.Import: self._import, ast.ImportFrom: self._import_from}

    def note(self, message: str) -> None:
        """Keep a line about what is passed over."""
        if len(self.notes) < 100:
            self.notes.setdefault(message, self.line)

    def read(self, script: str) -> None:
        """Go through a whole script. Raises `RefusalError` naming the line of what is not understood or too much."""
        collecting = gc.isenabled()
        gc.disable()  # it would go through the tree again and again; what is made is bounded
        try:
            tree, tokens = parse(script, self.limits)
            self.line = script.rstrip("\n").count("\n") + 1  # where the whole of it is too long
            self.budget.take_steps(_STEPS_OF_TOKEN * tokens)
            self.line = 1
            if "yield" in script:
                self.budget.take_steps(_STEPS_OF_WALK * tokens)
                self.yielding = yielding_nodes(tree)
            run = self.block(tree.body)
            run(Frame(self.builtins, {"__name__": "__main__", "__file__": SCRIPT}))
        except RaisedError as error:
            if error.name != "SystemExit" or error.said not in ("", "0", "None"):
                raise error.at(self.line) from None
        except RefusalError as refusal:
            raise refusal.at(self.line) from None
        except RecursionError:
            raise RefusalError("nested too deeply to be read", self.line) from None
        except MemoryError:
            raise RefusalError("too large to be read", self.line) from None
        finally:
            if collecting:
                gc.enable()

    def _import(self, node: ast.Import) -> Execute:
        def execute(frame: Frame) -> None:
            for alias in node.names:
                module = self._module(alias.name)
                top = alias.name.split(".")[0]
                frame.set(alias.asname or top, module if alias.asname else self._module(top))

        return execute

    def _import_from(self, node: ast.ImportFrom) -> Execute:
        def execute(frame: Frame) -> None:
            if node.level or node.module is None:
                raise RefusalError("an import relative to another file is not read")
            module = self._module(node.module)
            for alias in node.names:
                if alias.name == "*" and isinstance(module, Namespace):
                    self.budget.take_steps(len(module.values))
                    for name, value in module.values.items():
                        frame.set(name, value)
                elif alias.name.startswith(("*", "_")):
                    raise RefusalError(f"{node.module:.60}.{alias.name:.60} is not read")
                else:
                    frame.set(alias.asname or alias.name, self._name_in(module, alias.name))

        return execute

    def _module(self, name: str) -> Record:
        first, *rest = name.split(".")
        module = self.modules[first] if first in self.modules else Outside(first)
        for part in rest:
            if part.startswith("_"):
                raise RefusalError(f"import of {name:.60} is not read")
            found = self._name_in(module, part)
            if not isinstance(found, Record):
                raise RefusalError(f"import of {name:.60} is not read")
            module = found
        return module

    def _name_in(self, module: Record, name: str) -> Value:
        """What a module has under a name: nothing that is read, where it is not known."""
        try:
            return module.attribute(name)
        except RefusalError:
            return Outside(f"{module.kind}.{name:.60}")
