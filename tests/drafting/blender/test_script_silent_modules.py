from script_reading import agrees, refuses


def test_what_is_said_to_nobody_is_passed_over() -> None:
    agrees(
        "import gc, logging, sys, traceback, warnings\nlogging.basicConfig(level=logging.WARNING)\n"
        "log = logging.getLogger(__name__)\nlog.setLevel(logging.ERROR)\nlog.info('made %d', 3)\n"
        "log.addHandler(logging.StreamHandler(sys.stderr))\nlog.propagate = False\nlogging.debug('x')\n"
        "warnings.simplefilter('ignore')\nwarnings.warn('old')\nsys.stdout.flush()\ngc.collect()\n"
        "assert logging.INFO == 20"
    )


def test_what_writes_a_file_is_refused() -> None:
    refuses("import logging\nlogging.basicConfig(filename='/tmp/a')", "a log that is written to a file", 2)
    refuses("import logging\nlogging.FileHandler('/tmp/a')", "logging.FileHandler is not supported", 2)
    refuses("import sys\nsys.stdout.buffer", "sys.stdout has no 'buffer'", 2)
    refuses("import logging\nlogging.getLogger().handlers", "a logger has no 'handlers'", 2)
