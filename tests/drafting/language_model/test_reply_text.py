"""What models write around what they are asked for."""

import pytest

from lidardraft.drafting.language_model.reply_text import code_of, json_of

OBJECT = '{"road": {"kind": "bend"}, "groups": []}'
SCRIPT = "import bpy\n\nbpy.ops.mesh.primitive_cube_add()\n"


@pytest.mark.parametrize(
    "reply",
    [
        OBJECT,
        f"\n\n{OBJECT}\n",
        f"```json\n{OBJECT}\n```",
        f"```\n{OBJECT}\n```\nLet me know if you need more.",
        f"Here is the scene:\n\n~~~json\n{OBJECT}\n~~~",
        f"```json {OBJECT} ```",
        f"<think>A road {{with}} a bend...\n</think>\n\n{OBJECT}",
        f"Sure! {OBJECT}",
    ],
)
def test_an_object_among_other_words(reply: str) -> None:
    assert json_of(reply) == OBJECT


def test_where_there_is_no_object_all_of_it_is_given_back() -> None:
    assert json_of("I cannot } do { that") == "I cannot } do { that"
    assert json_of("") == ""


def test_an_object_that_is_cut_off_is_not_taken_for_a_smaller_one() -> None:
    assert json_of('```json\n{"road": {"kind": "bend"}, "groups": [{"kind"') == '{"road": {"kind": "bend"}'


@pytest.mark.parametrize(
    "reply",
    [
        SCRIPT,
        f"```python\n{SCRIPT}```",
        f"Install it:\n```sh\npip install bpy\n```\nThen:\n\n```python\n{SCRIPT}\n```\nEnjoy!",
        f"<think>\n```python\nx = 1\n```\n</think>\n~~~py\n{SCRIPT}~~~",
        f"  ```python\n{SCRIPT}  ```  ",
        f"```python\n{SCRIPT}",
    ],
)
def test_a_script_among_other_words(reply: str) -> None:
    assert code_of(reply) == SCRIPT


def test_a_script_is_never_taken_for_a_path() -> None:
    assert code_of("/etc/secrets.py") == "/etc/secrets.py\n"


def test_fences_that_are_never_closed_are_read_in_one_pass() -> None:
    """A pattern that looks for the end of each would take minutes."""
    reply = "\n".join("`" * n for n in range(2000, 2, -1)) + "\n~~~\n" + "x\n" * 1_000_000
    assert code_of(reply).endswith("x\n")


def test_braces_after_the_object_are_words() -> None:
    assert json_of(f"Here: {OBJECT} and enjoy {{it}}.") == OBJECT
