import subprocess
import sys

from lidardraft.drafting.cloud import rules
from lidardraft.semantics import BY_NAME


def test_the_rules_are_about_classes_that_exist():
    assert {*rules.POST_CLASSES, *rules.HANGING_CLASSES, *rules.REACH} <= set(BY_NAME)


def test_what_imitates_clustering_does_not_load_it():
    code = "import sys, lidardraft.streets; print(sorted({'sklearn', 'lark'} & set(sys.modules)))"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout.strip() == "[]"
