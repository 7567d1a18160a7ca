"""Where everything must be tested, what would be skipped has failed."""

from __future__ import annotations

import os
import signal
from collections import Counter
from collections.abc import Generator

import pytest
from hypothesis import HealthCheck, settings
from phaseplane.suspension import models

# no test counts on seconds: other programs may have the machine; a change is judged by the same
# draws each time, as recent versions of Hypothesis do of themselves
settings.register_profile(
    "busy",
    deadline=None,
    derandomize=bool(os.environ.get("CI")),
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("busy")

# what a shell starts in the background ignores interrupts, and so would all that the tests start
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

_SAMPLED = 3
_PLATFORM = "on this platform"  # what a skip that is right everywhere says: "not on this platform"


@pytest.fixture(autouse=True)
def _models_of_the_package() -> Generator[None, None, None]:
    """Forget the models that a test has registered: others go through all there are."""
    yield
    for name in models.ALL.keys() - models.FILES.keys():
        del models.MODELS[name], models.ALL[name]


@pytest.hookimpl(tryfirst=True)  # before slow tests are left out
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Let all but every third case of a test marked `sampled` be slow."""
    seen: Counter[str] = Counter()
    for item in items:
        if item.get_closest_marker("sampled") is not None:
            name = item.nodeid.partition("[")[0]
            if seen[name] % _SAMPLED:
                item.add_marker(pytest.mark.slow)
            seen[name] += 1


def refuse(report: pytest.TestReport | pytest.CollectReport) -> None:
    """Turn a skip into a failure if `CI` is set: there all tools and packages are to be had."""
    if not (os.environ.get("CI") and report.skipped) or hasattr(report, "wasxfail"):
        return
    *_, reason = report.longrepr if isinstance(report.longrepr, tuple) else (str(report.longrepr),)
    if _PLATFORM not in reason:
        report.outcome = "failed"
        report.longrepr = f"{reason}; where CI is set, nothing may be missing"


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport() -> Generator[None, pytest.TestReport, pytest.TestReport]:
    report = yield
    refuse(report)
    return report


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report() -> Generator[None, pytest.CollectReport, pytest.CollectReport]:
    report = yield
    refuse(report)
    return report
