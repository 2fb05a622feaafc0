"""A stage of campaigns.mk is done again exactly where something changed.

    python fleet/test_campaigns.py PROGRAMS FOLDER
"""

import json
import os
import shutil
import subprocess
import sys
import time

import network

HERE = os.path.dirname(os.path.abspath(__file__))


def main(programs, folder):
    os.makedirs(f"{folder}/in")
    # Programs of its own, so that their times can be changed.
    shutil.copytree(programs, f"{folder}/bin")

    def make(*arguments):
        """What was done, in words of the rules."""
        given = [f"BIN={folder}/bin", f"OUT={folder}/out", "STAGES=scalarcal correct", *arguments]
        done = subprocess.run(["make", "-f", f"{HERE}/campaigns.mk", "-j2", *given], capture_output=True, text=True)
        assert done.returncode == 0, done.stdout + done.stderr
        # What the test changes next must be newer than what was done, by the file system's clock of some milliseconds.
        time.sleep(0.05)
        return sorted(line for line in done.stdout.splitlines() if not line.startswith("make"))

    def recording(number):
        start = network.datetime.date(2026, 3, 1)
        plan = network.plan("orbit", number, start, 86400, 60)
        done = subprocess.run([f"{programs}/simulate", "campaign", "-q"], input=json.dumps(plan), capture_output=True, text=True, check=True)
        with open(f"{folder}/in/{'abc'[number]}.json", "w") as file:
            file.write(done.stdout)

    given = f"IN={folder}/in"
    for number in range(3):
        recording(number)
    all_of = lambda stage: [f"{stage} {name}" for name in "abc"]
    expect(make(given), all_of("correct") + all_of("scalarcal"), "at first, everything")
    expect(make(given), [], "then nothing")
    recording(1)
    expect(make(given), [], "a campaign that was written again with the same bytes")
    text = open(f"{folder}/in/b.json").read()
    assert '"title"' in text
    open(f"{folder}/in/b.json", "w").write(text.replace('"title": "', '"title": "again, ', 1))
    expect(make(given), ["correct b", "scalarcal b"], "one campaign that changed")
    expect(make(given), [], "then nothing")
    os.utime(f"{folder}/bin/correct")
    expect(make(given), all_of("correct"), "another program of the last stage")
    os.utime(f"{folder}/bin/scalarcal")
    expect(make(given), all_of("scalarcal"), "another program of the first stage that writes the same")
    expect(make(given), [], "then nothing")
    recording(2)
    shutil.move(f"{folder}/in/c.json", f"{folder}/in/d.json")
    shutil.copy(f"{folder}/in/d.json", f"{folder}/in/c.json")
    expect(make(given), ["correct d", "scalarcal d"], "one campaign more")

    plan = network.plan("orbit", 0, network.datetime.date(2026, 3, 1), 86400, 60)
    with open(f"{folder}/plan.json", "w") as file:
        json.dump(plan, file)
    seeds = [f"PLAN={folder}/plan.json", f"OUT={folder}/simulated", "SEEDS=4 5"]
    done = [f"{stage} seed-{seed}" for stage in ("correct", "scalarcal", "simulate") for seed in (4, 5)]
    expect(make(*seeds), done, "campaigns that are simulated")
    expect(make(*seeds[:2], "SEEDS=4 5 6"), [f"{stage} seed-6" for stage in ("correct", "scalarcal", "simulate")], "one seed more")
    print("campaigns.mk: each stage is done again exactly where something changed")


def expect(done, expected, when):
    assert done == sorted(expected), f"{when}: {done} was done, not {sorted(expected)}"


if __name__ == "__main__":
    main(*sys.argv[1:])
