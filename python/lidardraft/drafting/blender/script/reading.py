"""A script, carried out value by value. Nothing of it is ever run by Python."""

from __future__ import annotations

import gc

from lidardraft.drafting.blender.script.builtin_functions import builtin_functions
from lidardraft.drafting.blender.script.functions import Frame
from lidardraft.drafting.blender.script.limits import RaisedError, RefusalError, Script
from lidardraft.drafting.blender.script.source import parse
from lidardraft.drafting.blender.script.statements import generators_in, result_of
from lidardraft.drafting.blender.script.stub_modules import SCRIPT_FILE

_STEPS_OF_TOKEN = 6  # what parsing it takes
_STEPS_OF_WALK = 2  # what going once more through the tree takes, for a token


def read(text: str, script: Script) -> None:
    """Go through a whole script. Raises `RefusalError` naming the line of what is not understood or too much."""
    collecting = gc.isenabled()
    gc.disable()  # it would go through the tree again and again; what is made is bounded
    try:
        tree, tokens = parse(text, script.limits)
        script.line = text.rstrip("\n").count("\n") + 1  # where the whole of it is too long
        script.take_steps(_STEPS_OF_TOKEN * tokens)
        script.line = 1
        if "yield" in text:
            script.take_steps(_STEPS_OF_WALK * tokens)
            script.generators = generators_in(tree)
        builtins = Frame(None, builtin_functions(script), script)
        result_of(tree.body, Frame(builtins, {"__name__": "__main__", "__file__": SCRIPT_FILE}, script))
    except RaisedError as error:
        if error.name != "SystemExit" or error.said not in ("", "0", "None"):
            raise error.at(script.line) from None
    except RefusalError as refusal:
        raise refusal.at(script.line) from None
    except RecursionError:
        raise RefusalError("nested too deeply to be read", script.line) from None
    except MemoryError:
        raise RefusalError("too large to be read", script.line) from None
    finally:
        if collecting:
            gc.enable()
