"""Writes the page on real recordings, with its pictures beside it."""
import argparse
import tomllib
from collections.abc import Callable
from pathlib import Path

from . import alone, pairs, scalars, turned
from .page import Page, table
from .programs import Programs

WORDS = tomllib.loads(Path(__file__).with_name("sets.toml").read_text())
# All sets, in the order of the page; what is said of them is in sets.toml.
SETS: dict[str, Callable[[Programs, Page], None]] = {
    "conrad-pair": pairs.conrad, "cobenzl-pair": pairs.cobenzl, "meson-hall": pairs.meson_hall,
    "quadrotor": pairs.quadrotor, "balloon": pairs.balloon, "boulder-published": pairs.boulder,
    "boulder-2016": scalars.boulder_month, "boulder-2014": scalars.boulder_storm, "conrad-scalar": scalars.conrad,
    "vernadsky": scalars.vernadsky, "cobenzl-scalar": scalars.cobenzl, "w2naf": alone.w2naf,
    "marg-static": alone.marg, "marg-rotations": turned.marg, "phone": turned.phone,
    "marg-scalarcal": turned.marg_scalarcal, "phone-scalarcal": turned.phone_scalarcal,
    "quadrotor-scalarcal": turned.michigan_scalarcal, "square-wave": alone.square_wave,
    "gradiometer": alone.gradiometer, "certificates": alone.certificates,
}


def run(programs: Programs, names: list[str]) -> dict[str, Page | None]:
    """Pages of sets; None where the folder is missing."""
    pages = {}
    for name in names:
        words = WORDS["page"] | WORDS[name]
        pages[name] = Page(words) if (programs.data / words["folder"]).is_dir() else None
        if page := pages[name]:
            SETS[name](programs, page)
            page.say(f"**Not determined:** {words['undecided']}")
            page.say(f"Source: {words['source']}. `{name}`")
        else:
            print(f"{name}: not run, no folder {words['folder']} with the recordings")
    return pages


def whole(pages: dict[str, Page | None]) -> str:
    """The page of all sets."""
    words, there = WORDS["page"], {name: page for name, page in pages.items() if page}
    heads = [[WORDS[name]["title"], " ".join(page.headline) if page else "not run"] for name, page in pages.items()]
    predictions = [(WORDS[name]["title"], one) for name, page in there.items() for one in page.predictions]
    known = sorted((one for page in there.values() for one in page.known), key=lambda one: one[4])
    sections = [f"# {words['title']}\n", f"{words['about']}\n", table(["question", "result"], heads),
                f"## By hand\n\n{words['by_hand']}\n",
                f"The programs are within 5 % of it, or better, in {sum(one.holds for _, one in predictions)} of "
                f"{len(predictions)} predictions.\n",
                table(["held out", "best by hand", "by hand, nT", "programs, nT", "ratio", "within 5 %"],
                      [one.row(title) for title, one in predictions]),
                f"## Known from the source\n\n{words['known']}\n",
                table(["known from", "what", "a stage that was not told", "found"],
                      [[source, what, f"`{program}`: {answer}", "yes" if found else "**no**"]
                       for source, what, program, answer, found in known])]
    for name, page in pages.items():
        missing = [f"Not run: no folder `{WORDS[name]['folder']}` with the recordings.\n"]
        sections += [f"## {WORDS[name]['title']}\n", *(page.text if page else missing)]
    return "\n".join(sections)


def main() -> None:
    parser = argparse.ArgumentParser(prog="fluxcal_proof.recordings", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"sets; absent: all of {', '.join(SETS)}")
    parser.add_argument("--programs", type=Path, default=Path("target/release"), help="the programs' folder")
    parser.add_argument("--data", type=Path, default=Path("../shared/data"), help="the folder of the recordings")
    parser.add_argument("-o", "--output", type=Path, default=Path("docs/proof/real.md"))
    arguments = parser.parse_args()
    if unknown := set(arguments.names) - set(SETS):
        parser.error(f"no set {', '.join(sorted(unknown))}; expected of {', '.join(SETS)}")
    pages = run(Programs(arguments.programs, arguments.data), arguments.names or list(SETS))
    arguments.output.parent.mkdir(parents=True, exist_ok=True)
    arguments.output.write_text(whole(pages))
    for page in filter(None, pages.values()):
        for name, svg in page.plots.items():
            arguments.output.with_name(name).write_text(svg)


if __name__ == "__main__":
    main()
