# Every recipe is a plain command that can be typed without just.

# Lints and format
check:
    cargo fmt --all -- --check
    cargo clippy --workspace --all-targets -- -D warnings
    crates/report/types.sh

# All tests
test:
    cargo test --workspace

# Tests on real recordings, which are not in the repository: in the folder FLUXCAL_DATA, else in ../shared/data
recordings:
    cargo build --workspace
    cargo test --workspace --test it -- --ignored real::

# Golden cases and schemas only
golden:
    cargo test --workspace --test it -- golden:: schema:: bad_input:: effects:: conformity:: certificate::

# What an empty target directory takes: to the README's first result, and through the tests; then what a changed line takes
times:
    rm -rf target/times
    time sh -c 'CARGO_TARGET_DIR=target/times cargo build --release && target/times/release/simulate campaign -q fixtures/plans/magsat-axes.json | target/times/release/axescal -q > /dev/null'
    time env CARGO_TARGET_DIR=target/times cargo test --workspace
    touch crates/axescal/src/solve.rs
    time env CARGO_TARGET_DIR=target/times cargo test -p axescal
    touch crates/common/src/time.rs
    time env CARGO_TARGET_DIR=target/times cargo build --release

# Write golden documents, messages and schemas anew; read the difference before it is kept
bless:
    BLESS=1 cargo test --workspace --test it -- golden:: schema:: bad_input:: effects:: conformity:: certificate::

# Every program on fixtures that were changed: ten minutes from a seed, the files of findings kept (`--case N` repeats one)
fuzz seed="1" minutes="10":
    cargo run --release -p fuzz -- --build --seed {{seed}} --minutes {{minutes}} --keep target/fuzz

# Speed, as ratios against a peer in the same run
bench:
    cargo bench -p axescal --bench axescal
    cargo bench -p simulate --bench simulate
    cargo bench -p sensorcal --bench sensorcal
    cargo bench -p tables --bench read
    cargo bench -p ingest --bench ingest
    cargo bench -p diffmag --bench stream
    cargo bench -p scalarcal --bench scalarcal
    cargo bench -p diagnose --bench diagnose
    FLUXCAL_ROWS=10000000 cargo bench -p correct --bench table
    cargo build --release && cargo build --profile dist && cargo bench -p program --bench profiles

# A network on a cluster of two workers of Apache Spark, and campaigns by make; needs Java 17 (Debian: openjdk-17-jre-headless), and fetches Spark
fleet-test: fleet-venv
    rm -rf target/fleet-test target/fleet-campaigns target/fleet-programs && mkdir target/fleet-programs
    cp target/release/simulate target/release/correct target/release/diffmag target/release/scalarcal target/fleet-programs
    target/fleet-venv/bin/python fleet/test_fleet.py target/fleet-programs target/fleet-test
    target/fleet-venv/bin/python fleet/test_campaigns.py target/fleet-programs target/fleet-campaigns

# A month of ten stations at 10 Hz: docs/fleet.md; 25 GB of disk and some half an hour
fleet-measure rate_hz="10" days="30" observatories="8" satellites="2": fleet-venv
    rm -rf target/fleet-measured
    target/fleet-venv/bin/python fleet/measure.py target/release target/fleet-measured docs/fleet.md {{rate_hz}} {{days}} {{observatories}} {{satellites}}

[private]
fleet-venv:
    cargo build --release -p simulate -p correct -p diffmag -p scalarcal
    test -x target/fleet-venv/bin/spark-submit || { python3 -m venv target/fleet-venv && target/fleet-venv/bin/pip install -q -r fleet/requirements.txt; }

# fluxcal beside NumPy, SciPy, pandas, Polars, PyArrow, orjson and allantools, which go into a virtual environment below target: docs/performance.md
bench-peers runs="5":
    cargo build --release --workspace --bins
    python3 -m venv target/peers && target/peers/bin/pip install --quiet -r peers/requirements.txt
    target/peers/bin/python peers/run.py --runs {{runs}} -o docs/performance.md

# Physics concealed and sealed, what diagnose finds of it, and recordings that somebody else made: docs/proof.md and docs/proof/real.md. Three
# steps with a folder that must be new: what was opened once is not scored again. 736 cases are sealed; with the 264 from real recordings 1 000.
proof folder="target/proof" cases="736": proof-venv
    cargo build --release --workspace --bins
    target/proof-venv/bin/python -m fluxcal_proof make -o {{folder}} --cases {{cases}} --recordings ../shared/data --programs target/release
    target/proof-venv/bin/python -m fluxcal_proof answer {{folder}} --programs target/release
    target/proof-venv/bin/python -m fluxcal_proof score {{folder}} -o docs/proof.md
    target/proof-venv/bin/python -m fluxcal_proof.recordings --programs target/release --data ../shared/data -o docs/proof/real.md

[private]
proof-venv:
    test -x target/proof-venv/bin/python || python3 -m venv target/proof-venv
    target/proof-venv/bin/pip install -q "./proof[rivals]"

# Coverage of every interval over 5 000 and 1 000 campaigns
prove:
    FLUXCAL_CAMPAIGNS=5000 cargo test --release -p axescal --test it coverage:: -- --nocapture
    FLUXCAL_CAMPAIGNS=1000 cargo test --release -p axescal --test it -- --nocapture design:: gradients::
    FLUXCAL_CAMPAIGNS=1000 cargo test --release -p coilcal -- --nocapture
    FLUXCAL_CAMPAIGNS=1000 cargo test --release -p sensorcal --test it -- --nocapture coverage:: trend::
    FLUXCAL_CAMPAIGNS=40 cargo test --release -p report --test it campaigns:: -- --nocapture
    FLUXCAL_CAMPAIGNS=1000 cargo test --release -p scalarcal --test it coverage:: -- --nocapture
    FLUXCAL_CAMPAIGNS=1000 cargo test --release -p scalarcal --test it -- --nocapture body:: vector::
    FLUXCAL_CAMPAIGNS=100 FLUXCAL_DAYS=30 cargo test --release -p scalarcal --test it orbit:: -- --nocapture
    FLUXCAL_CAMPAIGNS=1000 cargo test --release -p diffmag -- --nocapture
    FLUXCAL_DAYS=200 cargo test --release -p diffmag --test it steps:: -- --nocapture
    mkdir -p target/days && python3 fixtures/reference/disturbed_days.py 41 120 target/days
    python3 fixtures/reference/disturbed_days_score.py target/release/diffmag 41 160 target/days
    FLUXCAL_CAMPAIGNS=143 cargo test --release -p absolute --test it coverage:: -- --nocapture
    FLUXCAL_CAMPAIGNS=500 cargo test --release -p correct --test it campaign:: -- --nocapture
    FLUXCAL_CASES=all cargo test --release -p correct --test it joint::
    FLUXCAL_CAMPAIGNS=400 cargo test --release -p diagnose --test it coverage:: -- --nocapture
    FLUXCAL_CASES=all cargo test --release -p diagnose --test it joint::
    FLUXCAL_CAMPAIGNS=300 cargo test --release -p diagnose --test it clean:: -- --nocapture
    FLUXCAL_CASES=all cargo test --release -p diagnose --test it -- --nocapture outside:: several:: scalar::
    FLUXCAL_CASES=all FLUXCAL_TIMES=3,1,0.3 FLUXCAL_TABLE=table.md cargo test --release -p diagnose --test it single:: -- --nocapture

# All programs and `fluxcal`, which runs them, with man pages and bash completions, below ~/.local or PREFIX
install prefix="$HOME/.local":
    for program in simulate ingest series coilcal sensorcal axescal scalarcal starcal diffmag absolute diagnose correct report fluxcal; do \
        cargo install --locked --profile dist --path crates/$program --root {{prefix}} --target-dir target && \
        {{prefix}}/bin/$program --man {{prefix}}/share/man/man1 && \
        mkdir -p {{prefix}}/share/bash-completion/completions && \
        {{prefix}}/bin/$program --completions bash > {{prefix}}/share/bash-completion/completions/$program || exit 1; \
    done

# The wheel: the programs and the module of docs/python.md
wheel:
    mkdir -p target/wheel && rm -f target/wheel/*.whl
    cd python && python3 -c 'import backend; print(backend.build_wheel("../target/wheel"))'

# The wheel in an environment of its own, away from the sources; needs PyPI for pandas, Polars, PyArrow, matplotlib and mypy
wheel-test: wheel
    python/test_wheel.sh target/dist

# The documentation site from the same pages, in target/site/html; SUMMARY.md is its table of contents
site:
    test -x target/tools/bin/mdbook || cargo install mdbook --locked --version 0.5.4 --root target/tools
    rm -rf target/site && mkdir -p target/site/src
    cp -r --parents *.md fleet/README.md docs schemas fixtures/specs fixtures/certificate target/site/src
    target/tools/bin/mdbook build

# The main job, to look at
demo:
    cargo build --release
    ./target/release/simulate campaign fixtures/plans/magsat-axes.json | ./target/release/axescal > result.json

# The report's pages in headless Chromium, in both themes and on a phone's width (Debian: apt-get install chromium poppler-utils)
browser:
    cargo test -p report --test it browser:: -- --ignored
