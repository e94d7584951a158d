"""Options are checked where they are given; an error is one line."""

import argparse
import math
import subprocess
import sys
import textwrap

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rcr import script
from rcr._data import checks

WORDS = st.one_of(st.text(max_size=20), st.floats().map(repr), st.integers().map(str),
                  st.sampled_from(["1e400", "-0", "5e-324", "1_0", "٣", "0x1", "9" * 5000, "1e3",
                                   " 1", "1j"]))


@given(WORDS)
def test_numbers_and_paths(text):
    """Numbers are finite, within the range and of 64 bits; else one short line."""
    share = lambda v: 0 <= v < 1
    for kind, fits in ((script.number("0 ≤ x < 1", share), share),
                       (script.integer(), lambda v: isinstance(v, int) and abs(v) <= 2**63),
                       (script.at_least(3), lambda v: 3 <= v < 2**31),
                       (script.number(), math.isfinite),
                       (script.folder, lambda path: True), (script.new_file, lambda path: True)):
        try:
            assert fits(kind(text))
        except argparse.ArgumentTypeError as error:
            path = kind in (script.folder, script.new_file)
            assert path or ": expected " in str(error) and len(str(error)) < 200
            assert str(error) and "\n" not in str(error)


VALUES = st.one_of(st.floats(), st.integers(), st.complex_numbers(), st.text(max_size=3), st.none(),
                   st.booleans(), st.fractions(), st.decimals(), st.binary(max_size=3),
                   st.lists(st.floats(), max_size=2))


@given(VALUES)
def test_values_from_python(value):
    """Numbers are finite, within the range and of 64 bits; else one short line."""
    for check, kind in ((checks.number, float), (checks.integer, int)):
        try:
            assert type(check("x", value)) is kind and not isinstance(value, bool)
        except ValueError as error:
            assert str(error).startswith("x = ") and "; expected " in str(error)


def started(body):
    code = f"""
import sys
from rcr import script

def main():
{textwrap.indent(body, "    ")}

sys.argv = ["/some/where/x.py"]
script.run(main)
"""
    return subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE,
                            stderr=subprocess.PIPE, text=True)


@pytest.mark.parametrize("body, code, errors", [
    ("print('fine')", 0, ""),
    ("raise ValueError('a\\nb')", 1, "a b"),
    ("open('/none/x')", 1, "/none/x: No such file or directory"),
    ("raise KeyboardInterrupt", 130, "stopped"),
    ("raise script.Stopped('stopped here; go on so')", 130, "stopped here; go on so"),
    ("raise MemoryError", 1, "the memory does not suffice; choose a smaller problem"),
    ("sys.exit('why')", 1, "why"),
    ("script.Parser(prog='x.py').parse_args(['--what'])", 2, "unrecognized arguments: --what"),
])
def test_ends(body, code, errors):
    process = started(body)
    expected = ("", f"x.py: {errors}\n") if code else ("fine\n", "")
    assert process.communicate() == expected and process.returncode == code


def test_a_first_signal_stops_later_a_second_one_at_once():
    """A repetition within half a second, as `timeout` sends it, is no second one."""
    body = """
import time
with script.stoppable() as stop:
    print("in", flush=True)
    while not stop.asked:
        time.sleep(0.001)
    print("asked", flush=True)
    time.sleep(script.REPEAT)
    print("ready", flush=True)
    time.sleep(100)
"""
    for number in script.SIGNALS:
        process = started(body)
        assert process.stdout.readline() == "in\n"
        process.send_signal(number)
        assert process.stdout.readline() == "asked\n"
        process.send_signal(number)
        assert process.stdout.readline() == "ready\n"
        process.send_signal(number)
        assert process.communicate(timeout=60)[1] == "x.py: stopped\n"
        assert process.returncode == 128 + number


@pytest.mark.parametrize("number", script.SIGNALS)
def test_a_signal_ends_a_script_in_one_line(number):
    """Also while another thread makes the call."""
    bodies = ("print('in', flush=True); import time; time.sleep(100)",
              "print('in', flush=True); script.interruptible(__import__('time').sleep, 100)")
    for body in bodies:
        process = started(body)
        assert process.stdout.readline() == "in\n"
        process.send_signal(number)
        assert process.communicate(timeout=60)[1] == "x.py: stopped\n"
        assert process.returncode == 128 + number


def test_a_call_in_another_thread_returns_its_result_or_raises():
    assert script.interruptible(divmod, 7, 2) == (3, 1)
    with pytest.raises(ZeroDivisionError):
        script.interruptible(divmod, 7, 0)
