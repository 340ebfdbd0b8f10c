from script_reading import agrees, reads, refuses


def test_the_clock_stands_still() -> None:
    assert reads("import time\nassert time.time() == time.perf_counter()").notes == {"the time is taken as 0": 2}
    script = (
        "import datetime as d\nfrom datetime import datetime\nstart = datetime.now()\nx = d.datetime.now() - start\n"
        "assert x.total_seconds() == 0 and x.seconds == 0 and start.year == 1970\n"
        "assert f'{start}' == '1970-01-01 00:00:00' and datetime.now().isoformat() == '1970-01-01T00:00:00'\n"
        "assert str(x) == '0:00:00'"
    )
    assert list(reads(script).notes) == ["the time is taken as 0"]


def test_a_time_is_written_in_the_format_that_is_asked_for() -> None:
    reads(
        "from datetime import datetime\nimport time\nassert int(datetime.now().strftime('%Y')) == 1970\n"
        "assert time.strftime('%y%m%d_%H-%M-%S') == '700101_00-00-00'\nassert time.strftime('100%% x') == '100% x'"
    )
    refuses("import time\ntime.strftime('%Y %B')", "'%B' in the format of a time is not supported; %Y, ", 2)
    refuses("import time\ntime.strftime('%')", "'%' in the format of a time is not supported", 2)
    refuses("import time\ntime.strftime('%Y' * 51)", "a format of 102 characters; 100 are the most", 2)


def test_nobody_waits() -> None:
    agrees("import time\nassert time.sleep(0) is None")
    reads("import time\ntime.sleep(10**6)")


def test_what_is_no_time_is_refused() -> None:
    refuses("from datetime import datetime\ndatetime.now() + 1", "a moment", 2)
    refuses("from datetime import timedelta\ntimedelta(days=1)", "a call of datetime.timedelta", 2)
    refuses("import time\ntime.strftime(5)", "the format is 5", 2)
