"""`python3 -m fluxcal_proof`: make, answer, score, and one case again."""
import argparse
import json
import sys
from pathlib import Path

from . import answer, cases, folder, page, score


def main() -> int:
    parser = argparse.ArgumentParser(prog="fluxcal_proof", description=__doc__)
    steps = parser.add_subparsers(dest="step", required=True)
    make = steps.add_parser("make", help="make and seal a round in a new folder")
    make.add_argument("-o", "--output", type=Path, required=True)
    make.add_argument("--cases", type=int, default=1000)
    make.add_argument("--only", choices=["all", "campaigns", "pairs"], default="all")
    make.add_argument("--seed", type=int, help="absent: a random number of the operating system")
    make.add_argument("--recordings", type=Path, help="folder of real recordings: they and injections in them are added; needs --programs")
    make.add_argument("--programs", type=Path, help="folder of ingest, which reads the recordings")
    reply = steps.add_parser("answer", help="have the programs answer the documents")
    reply.add_argument("folder", type=Path)
    reply.add_argument("--programs", type=Path, required=True, help="folder of diagnose, diffmag and simulate")
    reply.add_argument("--timeout", type=float, default=60.0, help="seconds for an answer")
    opened = steps.add_parser("score", help="open the truths and score the answers")
    opened.add_argument("folder", type=Path)
    opened.add_argument("-o", "--output", type=Path, help="write the page here")
    one = steps.add_parser("case", help="make one case again")
    one.add_argument("--seed", type=int, required=True)
    one.add_argument("--number", type=int, required=True)
    one.add_argument("-o", "--output", type=Path, required=True)
    for step in (make, one):
        step.add_argument("--set", choices=["develop", "score"], default="score")
    options = parser.parse_args()
    try:
        if options.step == "make":
            if options.recordings and not options.programs:
                parser.error("--recordings needs --programs")
            real = (options.recordings, options.programs) if options.recordings else None
            print("commitment", folder.make(options.output, options.seed, options.cases, options.set, options.only, real))
        elif options.step == "answer":
            answer.all_of(options.folder, options.programs, options.timeout)
        elif options.step == "score":
            scored = score.read(options.folder)
            print(page.terminal(scored))
            if options.output:
                page.write(scored, options.output)
        else:
            case = cases.make(options.seed, options.number, options.set)
            options.output.write_text(json.dumps(case.document))
            print(json.dumps(case.truth, indent=1))
    except folder.Refused as reason:
        print(reason, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
