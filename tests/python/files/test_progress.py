"""The progress of a test: a reader sees whole numbers, or None while no test runs."""

import threading

import pytest
from rcr.study import progress


def test_a_reader_sees_whole_numbers(tmp_path):
    assert progress.read(tmp_path) is None
    progress.write(tmp_path, 2.5)
    assert progress.read(tmp_path) == (2.5, 0.0, 0.0)
    progress.write(tmp_path, 0.0)
    numbers = [index / 1000 for index in range(1000)]
    writer = threading.Thread(
        target=lambda: [progress.write(tmp_path, 1000 * x, x, x / 2) for x in numbers])
    writer.start()
    seen = []
    while writer.is_alive():
        seen.append(progress.read(tmp_path))
    assert len(seen) > 10
    assert all(numbers == pytest.approx((1000 * numbers[1], numbers[1], numbers[1] / 2), abs=2e-6)
               for numbers in seen)
    progress.remove(tmp_path)
    progress.remove(tmp_path)
    assert progress.read(tmp_path) is None and not any(tmp_path.iterdir())


def test_a_missing_folder_is_no_error(tmp_path):
    progress.write(tmp_path / "none", 2.5, 0.1, 0.5)
    assert progress.read(tmp_path / "none") is None
