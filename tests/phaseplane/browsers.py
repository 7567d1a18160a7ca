"""A browser without a window, for the tests of pages; they are skipped where there is none."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest

FREE = """
const boxes = [...document.querySelectorAll('.paper text')].map(text => text.getBoundingClientRect());
const across = (a, b) => Math.min(a.right, b.right) - Math.max(a.left, b.left);
const down = (a, b) => Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
const meet = (a, b) => across(a, b) > 1 && down(a, b) > 0.4 * Math.min(a.height, b.height);
return boxes.every((a, i) => boxes.every((b, k) => k <= i || !meet(a, b)));
"""
"""Whether no text on a sheet covers another.

Boxes are as high as a line, of which 15 % above and below its letters may overlap; in those of letters
and of values, three quarters as large, that is 35 % of the lower one.
"""


@contextmanager
def browser(*arguments: str, size: tuple[int, int] = (1300, 900)) -> Iterator[Any]:
    """Yield a browser with a window of this size, and end it."""
    webdriver = pytest.importorskip("selenium.webdriver")
    program, driver = (shutil.which(name) for name in ("chromium", "chromedriver"))
    if not program or not driver:
        pytest.skip("no browser: install chromium and chromium-driver")
    options = webdriver.ChromeOptions()
    options.binary_location = program
    window = "window-size={},{}".format(*size)
    for argument in ("no-sandbox", "disable-gpu", "disable-dev-shm-usage", window, *arguments):
        options.add_argument(f"--{argument}")
    opened = webdriver.Chrome(options, webdriver.ChromeService(driver))
    try:
        yield opened
    finally:
        opened.quit()
