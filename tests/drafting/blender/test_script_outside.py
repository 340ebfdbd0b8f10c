import pytest
from script_reading import reads, refuses

from lidardraft.drafting.blender.script.limits import RefusalError
from lidardraft.drafting.blender.script.values import Outside, describe


def test_a_name_is_all_that_is_known_of_it() -> None:
    part = Outside("socket").attribute("create_connection")
    assert describe(part) == "socket.create_connection"
    assert len(describe(part.attribute("a" * 10**6))) == 60
    with pytest.raises(RefusalError, match=r"a call of socket\.create_connection: a script is read, not run"):
        part.call([], {})
    reads("import socket\nx = [socket, socket.a, socket.b]\nassert x[0] is socket and x[1] is not None")


@pytest.mark.parametrize("use", ["m == 1", "m != m.a", "not m", "1 if m.x else 2", "f'{m}'", "str(m.x)", "m[0]"])
def test_its_value_is_never_taken_for_one(use: str) -> None:
    refuses(f"import socket as m\n{use}", "socket", 2)
