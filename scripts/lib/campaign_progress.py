"""Progress of a campaign on stderr.

A line says how each test and each stage of the report has ended. On a terminal, a bar below these
lines shows each test that runs.
"""

import json
import sys
import time

from tqdm import tqdm

from rcr.study import progress

BAR = "{desc} |{bar:24}|"
LEAST = 0.02  # share of the steps for an estimate of the time that is left
OTHER = "{desc} … {elapsed}"
REPORT = "network.py: "  # start of a line of scripts/network.py about the stage that begins


def show(line):
    """Print a line above the bars."""
    tqdm.write(f"campaign.py: {line}", file=sys.stderr)


class Test:
    """Progress of the biaxial test `name` in a folder."""

    def __init__(self, name, folder, strain):
        self.name, self.folder, self.strain = name, folder, strain
        self.bar = self.stage = None
        self.is_complete = self.summary.exists()

    @property
    def summary(self):
        return self.folder / "summary.json"

    @property
    def has_checkpoint(self):
        return (self.folder / progress.CHECKPOINT).exists()

    def update(self):
        """Follow the test; print a line at its end."""
        now = progress.read(self.folder)
        if now is None:
            self._check_end()
            return
        self.seconds, strain, share = now
        stage = "shear" if share else "compaction"
        if stage != self.stage:
            self._begin(stage, share)
        if share != self.bar.n:
            self.bar.n, passed = share, time.monotonic() - self.bar_start
            made = share - self.first
            self.end = time.monotonic() + passed * (1 - share) / made if made > LEAST else None
        if share:
            self.bar.bar_format = f"{BAR} {self._time_left()}"
        reached = f": strain {strain:.3f} of {self.strain:g}" if share else ", compaction"
        self.bar.set_description_str(self.name + reached)

    def _begin(self, stage, share):
        self.close()
        self.stage, self.end, self.first, self.bar_start = stage, None, share, time.monotonic()
        width = progress.columns()
        self.bar = tqdm(desc=self.name, total=1, initial=share, bar_format=BAR if share else OTHER,
                        disable=None, leave=False, ncols=width, dynamic_ncols=width is None)

    def _time_left(self):
        if self.end is None:
            return "? left"
        return f"{tqdm.format_interval(max(0, self.end - time.monotonic()))} left"

    def _check_end(self):
        """Print the line of a test that has ended, perhaps between two updates."""
        was_seen = self.stage is not None
        if self.is_complete or not (was_seen or self.summary.exists()):
            return
        self.close()
        self.stage, self.is_complete = None, self.summary.exists()
        if self.is_complete:
            result = json.loads(self.summary.read_text())
            ratio = "unknown" if result["sin_phi"] is None else f"{result['sin_phi']:.3f}"
            show(f"{self.name}: complete after {result['wall_seconds']:.0f} s, q/p = {ratio}")
        else:
            show(f"{self.name}: stopped after {self.seconds:.0f} s")

    def close(self):
        if self.bar is not None:
            self.bar.clear()  # close alone leaves the cursor right of a bar that is not the first
            self.bar.close()
        self.bar = None


class Report:
    """Progress of the report, from its log."""

    def __init__(self, log):
        self.log, self.begin = log, time.time()
        self.bar, self.stages = None, []  # of (name, start)

    def update(self):
        try:
            if self.log.stat().st_mtime < self.begin:
                return  # of an earlier campaign
            lines = self.log.read_text(errors="replace").splitlines()
        except OSError:
            return
        names = [line.removeprefix(REPORT).removesuffix(" …") for line in lines
                 if line.startswith(REPORT) and line.endswith(" …")]
        for name in names[len(self.stages):]:
            self.close()
            self.stages.append((name, time.monotonic()))
            self.bar = tqdm(desc=name, bar_format=OTHER, disable=None, leave=False)
        if self.bar is not None:
            self.bar.refresh()

    def close(self):
        """End the last stage with a line."""
        if self.bar is not None:
            self.bar.close()
            self.bar = None
            name, start = self.stages[-1]
            show(f"{name}: {time.monotonic() - start:.0f} s")


class Progress:
    """Progress of all tests, a list of `Test`, and of the report with this log."""

    def __init__(self, tests, log):
        self.tests, self.report = tests, Report(log)
        for test in tests:
            progress.remove(test.folder)  # of a test that was killed

    def __enter__(self):
        return self

    def __exit__(self, kind, *_):
        self.update()
        if kind is None:
            self.report.close()
        for test in self.tests:
            test.close()

    def update(self):
        for part in (*self.tests, self.report):
            part.update()
