"""Writes the page on real recordings, with its pictures beside it."""
import argparse
from collections import defaultdict
from pathlib import Path

from . import alone, lengths, pairs
from .lengths import CONRAD_NT, VERNADSKY_NT
from .page import Page
from .programs import DAY_S, TOML, Programs, Refused

# All sets, in the order of the page; what is said of them and where their files are is in sets.toml.
SETS = {
    "conrad-pair": pairs.conrad, "cobenzl-pair": pairs.cobenzl, "meson-hall": pairs.meson_hall, "quadrotor": pairs.quadrotor,
    "balloon": pairs.balloon, "boulder-published": pairs.boulder, "boulder-2016": lengths.boulder_month,
    "boulder-2014": lambda p, page: lengths.study(p, page, p.read("boulder-2014").complete().means(300).split(4 * DAY_S)),
    "conrad-scalar": lambda p, page: lengths.study(p, page, [lengths.read_conrad(p, date, 60) for date in page.words["parts"]], CONRAD_NT),
    "vernadsky": lambda p, page: lengths.study(p, page, p.read("vernadsky").complete().means(60).split(DAY_S * 2 / 3), VERNADSKY_NT),
    "cobenzl-scalar": lengths.cobenzl, "w2naf": alone.w2naf, "marg-static": alone.marg, "marg-rotations": lengths.marg,
    "phone": lengths.phone, "marg-scalarcal": lengths.runs, "phone-scalarcal": lengths.runs, "quadrotor-scalarcal": lengths.runs,
    "square-wave": alone.square_wave, "gradiometer": alone.gradiometer,
}


def run(programs: Programs, name: str) -> Page:
    """One set; where its folder is missing the page says so."""
    words = TOML["page"] | TOML["sets"][name]
    page, folder = Page(words), words["folder"]
    if not (programs.data / folder).is_dir():
        page.headline.append("not run")
        page.say(f"Not run: no folder `{folder}` with the recordings.")
        return page
    try:
        SETS[name](programs, page)
    except Refused as refusal:
        page.headline.append(f"`{refusal.program}` refuses.")
        page.refused(refusal)
    page.text.insert(0, words["about"].format_map(defaultdict(lambda: "unknown", page.about)) + "\n")
    page.say(f"**Not determined:** {words['undecided']}")
    page.say(f"Source: {TOML['sources'][folder]}. `{name}`")
    return page


def whole(pages: list[Page]) -> str:
    """The page of all sets."""
    words, top = TOML["page"], Page({})
    predictions = [(page.words["title"], one) for page in pages for one in page.predictions]
    known = sorted(((page.words["known"], *one) for page in pages for one in page.known), key=lambda one: one[2])
    top.say(words["head"])
    top.table(["question", "result"], [[page.words["title"], " ".join(page.headline)] for page in pages])
    top.say(words["by_hand"].format(holds=sum(one.holds for _, one in predictions), all=len(predictions)))
    heads = ["held out", "best by hand", "by hand, nT", "programs, nT", "ratio", "within 5 %"]
    top.table(heads, [one.row(title) for title, one in predictions])
    top.say(words["known_from_source"])
    top.table(["known from", "what", "a stage that was not told", "found"], [
        [source, what, f"`{program}`: {answer}", "yes" if found else "**no**"] for (source, what, program), answer, found in known])
    for page in pages:
        top.say(f"## {page.words['title']}")
        top.text += page.text
    return "\n".join(top.text)


def main() -> None:
    parser = argparse.ArgumentParser(prog="fluxcal_proof.recordings", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(SETS)}; absent: all")
    parser.add_argument("--programs", type=Path, default=Path("target/release"), help="the programs' folder")
    parser.add_argument("--data", type=Path, default=Path("../shared/data"), help="the folder of the recordings")
    parser.add_argument("-o", "--output", type=Path, default=Path("docs/proof/real.md"))
    arguments = parser.parse_args()
    if not set(arguments.names) <= set(SETS):
        parser.error(f"no such set; expected of {', '.join(SETS)}")
    pages = [run(Programs(arguments.programs, arguments.data), name) for name in arguments.names or SETS]
    arguments.output.parent.mkdir(parents=True, exist_ok=True)
    arguments.output.write_text(whole(pages))
    for name, svg in (plot for page in pages for plot in page.plots.items()):
        arguments.output.with_name(name).write_text(svg)


if __name__ == "__main__":
    main()
