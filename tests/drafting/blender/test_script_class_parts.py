from script_reading import agrees, refuses

DATACLASS = "from dataclasses import dataclass\n"


def test_decorators_may_be_called_with_what_changes_no_shape() -> None:
    agrees(DATACLASS + "@dataclass(frozen=True, order=True)\nclass A:\n    x: int\nassert A(1).x == 1")
    agrees(DATACLASS + "@dataclass()\nclass A:\n    x: int = 2\nassert A().x == 2")


def test_only_a_property_has_a_setter() -> None:
    script = "class A:\n    @staticmethod\n    def f():\n        pass\n    @f.setter\n    def f(x):\n        pass"
    refuses(script, "'setter'", 5)
