import argparse
import inspect

import pytest

from lidardraft.cli.arguments import add_weights
from lidardraft.diffusion.sampling_defaults import STEPS
from lidardraft.pipeline import Pipeline


@pytest.mark.parametrize("function", [Pipeline, Pipeline.from_pretrained])
def test_python_and_the_command_line_sample_alike(function: object) -> None:
    parser = argparse.ArgumentParser()
    add_weights(parser)
    assert parser.parse_args([]).steps == STEPS
    assert inspect.signature(function).parameters["steps"].default == STEPS
