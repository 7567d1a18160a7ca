"""Examines drawn systems and says how far off the package is.

    python tests/campaign --count 1000 --seed 0 --jobs 2 --to campaign.jsonl

Results are appended to the file, one line for each system; systems that are in it are not examined
again, so a campaign that was stopped goes on where it was.
"""

from __future__ import annotations

import argparse
import functools
import json
import os
import sys
from collections.abc import Callable
from multiprocessing import Pool
from pathlib import Path
from typing import Any

from phaseplane.suspension import engine

sys.path += (str(Path(__file__).parents[1] / name) for name in ("reference", "shared"))
import judging
import reducing
import report
from draws import Drawn, draw, draw_own


def examined(draw: Callable[[int], Drawn], seed: int) -> dict[str, Any]:
    """All about the system of that number."""
    drawn = draw(seed)
    try:
        return judging.examine(drawn)
    except Exception as error:
        line = f"{type(error).__name__}: {error}"
        return {"seed": seed, "model": drawn.model, "errors": {}, "failures": [line]}


def known(path: Path) -> dict[int, dict[str, Any]]:
    """The results in a file; a last line that was not finished is cut off."""
    if not path.exists():
        return {}
    whole = path.read_bytes()
    complete = whole[: whole.rfind(b"\n") + 1]
    if len(complete) < len(whole):
        os.truncate(path, len(complete))
    results = map(json.loads, complete.decode("ascii").splitlines())
    return {result["seed"]: result for result in results}


def main() -> int:
    """Examine, report; 1 if something is wrong that the systems do not explain."""
    parser = argparse.ArgumentParser(prog="python tests/campaign", description=__doc__)
    parser.add_argument("--count", type=int, default=300, help="number of systems")
    parser.add_argument("--seed", type=int, default=0, help="number of the first")
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    parser.add_argument(
        "--own", action="store_true", help="with elements that only systems of one's own can have"
    )
    parser.add_argument(
        "--to", type=Path, help="file of results, by default campaign.jsonl or, of --own, own.jsonl"
    )
    parser.add_argument("--show", action="store_true", help="only print the system --seed")
    parser.add_argument(
        "--reduce",
        metavar="FAILURE",
        help="only print which parameters of the system --seed a failure needs, given by its words, "
        "such as 1e-06 or 'mean, 0.0005 s'",
    )
    args = parser.parse_args()
    drawing = draw_own if args.own else draw
    path = args.to or Path("own.jsonl" if args.own else "campaign.jsonl")
    if args.show or args.reduce:
        drawn = drawing(args.seed)
        if args.reduce:
            say = functools.partial(print, file=sys.stderr, flush=True)
            drawn = reducing.reduced(drawn, args.reduce, say)
        print(reducing.as_json(drawn))
        return 0
    if engine.why_uncompiled:
        print(
            f"the kernel runs uncompiled, many times slower: {engine.why_uncompiled}",
            file=sys.stderr,
        )
    results = known(path)
    wanted = range(args.seed, args.seed + args.count)
    missing = [seed for seed in wanted if seed not in results]
    with path.open("a", encoding="ascii") as file, Pool(args.jobs) as pool:
        for done, result in enumerate(
            pool.imap_unordered(functools.partial(examined, drawing), missing), 1
        ):
            file.write(json.dumps(result) + "\n")
            file.flush()
            results[result["seed"]] = result
            for line in result["failures"]:
                print(f"{result['seed']} {result['model']}: {line}", flush=True)
            if sys.stderr.isatty():
                print(f"\r{done} of {len(missing)}", end="", file=sys.stderr)
    chosen = [results[seed] for seed in wanted if seed in results]
    print(report.text(chosen))
    return int(any(result["failures"] for result in chosen))


if __name__ == "__main__":
    sys.exit(main())
