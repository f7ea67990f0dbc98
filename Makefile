# Two commands are all it takes: `make demo` and `make test`. Both install what is missing first.

CARGO ?= cargo

# How programs of measurements run.
REPORT ?= $(CARGO) run --release -p ipopt-contact-report --
EXTREMES ?= $(CARGO) run --release -p ipopt-contact-scenes --bin extremes --
FUZZ_SCENES ?= $(CARGO) run --release -p ipopt-contact-scenes --bin fuzz_scenes --

# How long to look for mesh files that the readers fail on, and for problems that the Ipopt binding fails on.
SECONDS ?= 60

.PHONY: help install demo test test-ipopt-3.14 test-blas valgrind asan miri lint deny bench bench-growth bench-overhead report report-quick report-peers report-browse pressures extremes extremes-quick extremes-peers friction-peers meshes errors needs features mutants planted planted-quick package msrv bindings fuzz-readers fuzz-binding fuzz-scenes random-scenes

help:
	@echo "make demo              the paper's disc-in-disc: pictures, curves and files for ParaView"
	@echo "make test              all tests of all crates, with and without optional features"
	@echo "make test-ipopt-3.14   the tests of the Ipopt binding with a binary Ipopt 3.14, fetched aside"
	@echo "make test-blas         all tests with each BLAS, as on an old processor, and compiled for this one"
	@echo "make valgrind          the tests of the Ipopt binding under memcheck"
	@echo "make asan              the tests of the Ipopt binding under AddressSanitizer, which takes a nightly toolchain"
	@echo "make miri              its gate for callbacks under Miri, which takes a nightly toolchain"
	@echo "make lint              formatting, clippy and documentation, warnings as errors"
	@echo "make deny              licences, versions, sources and known defects of the crates below, by cargo-deny"
	@echo "make bench             times the disc-in-disc, the three beams and small strains, by each solver"
	@echo "make bench-growth      time and memory against the number of unknowns, within a quarter of an hour"
	@echo "make bench-overhead    what the Ipopt driver adds to Ipopt called from C and from C++"
	@echo "make report            error against run time: a page, tables and data in out/report, within an hour"
	@echo "make report-peers      error against run time of this library, GetFEM, CalculiX and FreeFEM on the same meshes; installs them"
	@echo "make report-quick      the same on few and coarse meshes, in out/report-quick; fails where bounds do not hold"
	@echo "make report-browse     opens the pages of FOLDER (out/report-quick) in Chromium, which it installs, and tells what a browser shows wrong"
	@echo "make pressures         errors of contact pressures and of work, in out/pressures, within some minutes"
	@echo "make extremes          scenes at the limits with their truths, by each solver: tables and data in out/extremes*, within an hour"
	@echo "make extremes-quick    two dozen of them, and all on coarse meshes by Newton's method; fails where a wrong result is claimed to be right"
	@echo "make extremes-peers    scenes at the limits by GetFEM and CalculiX, which it installs, and by this library, within an hour"
	@echo "make friction-peers    friction by GetFEM, which it installs, and by this library: a table of forces and times, within ten minutes"
	@echo "make meshes            standard scenes on many meshes: how many are complete and certified, data in out/meshes; ARGUMENTS are its options"
	@echo "make errors            estimated against true discretisation errors: data in out/errors, within two minutes"
	@echo "make needs             what runs cost beside what their scenes need: data in out/needs, within two minutes"
	@echo "make features          what each cargo feature costs to compile: clean builds, and their table in docs/needs.md"
	@echo "make mutants           plants faults one at a time and runs the tests (hours; an interrupted run goes on)"
	@echo "make planted           faults in the library that are compiled in for this command alone: which condition of the certificate sees which"
	@echo "make planted-quick     the cheapest ten of them"
	@echo "make package           the crates as packages, each checked on its own, and their documentation without Ipopt"
	@echo "make msrv              compiles with the oldest Rust that is promised to do"
	@echo "make fuzz-readers      damages mesh files at random for SECONDS (60) and reads them"
	@echo "make fuzz-binding      solves random problems with random options and faults for SECONDS (60), in other processes"
	@echo "make fuzz-scenes       solves random scenes, sound and wrong ones, for SECONDS (60)"
	@echo "make random-scenes     random scenes that are sound, of 22 kinds: how many come to their end and are certified"
	@echo "make bindings          renews the bindings to Ipopt kept in the source"

install:
	@./scripts/install.sh

demo: install
	$(CARGO) run --release --example disc_in_disc

# The dev profile optimises here and keeps its checks for overflow. The first line covers units, integration tests and the example that
# asserts its numbers, the second doctests. Then comes what does without Ipopt and shares its work among threads, and what does without
# libclang; the others, fewer features. `make lint` compiles the other examples and the benches.
test: install
	$(CARGO) test --workspace --tests
	$(CARGO) test --workspace --doc
	$(CARGO) test -p contact-core -p contact-fem --no-default-features --features threads --test threads
	$(CARGO) test -p ipopt-contact-sys -p contact-core --no-default-features --features contact-core/ipopt --tests
	$(CARGO) check -p contact-core -p contact-fem --no-default-features --lib --profile test
	$(CARGO) check -p ipopt-contact --no-default-features
	$(CARGO) check -p contact-fem --features vtk
	$(CARGO) check -p contact-fem --features csv
	$(CARGO) check -p contact-fem --features plot
	$(CARGO) check -p contact-fem --features record

test-ipopt-3.14: install
	@./scripts/test_ipopt_3_14.sh

test-blas: install
	@./scripts/test_blas.sh

valgrind: install
	@./scripts/valgrind.sh

# Takes a nightly toolchain. The doctor measures memory, which is the sanitizer's here, as does the test of limited address spaces.
asan: install
	RUSTFLAGS=-Zsanitizer=address CXXFLAGS=-fsanitize=address ASAN_OPTIONS=detect_leaks=0 $(CARGO) +nightly test \
		-p contact-core --no-default-features --features ipopt --target x86_64-unknown-linux-gnu --lib --tests \
		--target-dir target/asan -- --skip a_factor_that_does_not_fit --skip diagnosis_names --skip more_workspace

# Takes a nightly toolchain with the component miri. What calls Ipopt cannot run there.
miri: install
	$(CARGO) +nightly miri test -p contact-core --no-default-features --features ipopt --lib -- \
		ipopt::callbacks ipopt::library ipopt::libraries gaps:: check::

lint: install
	$(CARGO) fmt --all --check
	$(CARGO) clippy --workspace --all-targets --all-features -- -D warnings
	RUSTDOCFLAGS="-D warnings" $(CARGO) doc --workspace --no-deps --all-features
	@if command -v python3 >/dev/null; then scripts/mutants/run.py --check; fi

# Not a part of `make lint`: it installs cargo-deny where that is missing.
deny:
	@./scripts/deny.sh

bench: install
	$(CARGO) bench --bench disc_in_disc
	$(CARGO) bench --bench three_beams
	$(CARGO) bench --bench condensed --features metis

bench-growth: install
	$(CARGO) bench --bench growth --features metis

bench-overhead: install
	$(CARGO) bench -p contact-core --bench overhead

# Both go on where they were interrupted.
report: install
	$(REPORT)

report-quick: install
	$(REPORT) --quick

# Goes on where it was interrupted. The machine should do nothing else meanwhile: runs beside which other processes work are left out of charts.
report-peers: install
	scripts/install_peers.sh
	$(CARGO) build --release --bin ipopt-contact
	PYTHONDONTWRITEBYTECODE=1 report/peers/campaign.py
	$(REPORT) --peers out/report-peers

# FOLDER is that of a report's pages; PICTURE=docs/report.png keeps a picture of the first page.
FOLDER ?= out/report-quick
report-browse:
	@scripts/browse_report.sh $(FOLDER) $(if $(PICTURE),--picture $(PICTURE))

# MESHES="a.mesh b.mesh" are further meshes of the ball, as scripts/ball.geo makes them.
pressures: install
	$(CARGO) run --release -p ipopt-contact-scenes --bin pressures -- $(if $(MESHES),--meshes $(MESHES))

extremes: install
	$(EXTREMES) --out out/extremes
	$(EXTREMES) --solver newton --out out/extremes-newton
	$(EXTREMES) --solver ipopt --coarse --out out/extremes-ipopt

extremes-quick: install
	$(EXTREMES) --quick --out out/extremes-quick
	$(EXTREMES) --quick --solver ipopt --out out/extremes-quick-ipopt
	$(EXTREMES) --coarse --solver newton --out out/extremes-newton

# An interrupted run goes on where it was; report/peers/stability.json is what is kept.
extremes-peers: install
	scripts/install_peers.sh
	$(CARGO) build --release -p ipopt-contact-scenes --bin extremes
	target/release/extremes --coarse --export out/stability/cases
	PYTHONDONTWRITEBYTECODE=1 report/peers/stability.py --out out/stability
	cp out/stability/stability.json report/peers/stability.json
	target/release/extremes --judge report/peers/stability.json

friction-peers: install
	scripts/install_peers.sh
	$(CARGO) build --release --bin ipopt-contact
	PYTHONDONTWRITEBYTECODE=1 report/peers/friction.py

# ARGUMENTS="--scenes ironing,beams --cases 10 --seed 7" takes some: --help has more. Fails below 99 % of a scene.
meshes: install
	$(CARGO) run --release -p ipopt-contact-scenes --bin meshes -- $(ARGUMENTS)

# ARGUMENTS="--scenes beams,ball" takes some.
errors: install
	$(CARGO) run --release -p ipopt-contact-scenes --bin errors -- $(ARGUMENTS)

needs: install
	$(CARGO) run --release -p ipopt-contact-scenes --bin needs

# ARGUMENTS="ipopt plane" builds these alone.
features: install
	@scripts/features.py $(ARGUMENTS)

# ARGUMENTS="certificate --units" takes an area, and unit tests alone: scripts/mutants/run.py --help has more.
mutants: install
	@command -v python3 >/dev/null || { echo "python3 is missing"; exit 1; }
	@scripts/mutants/run.py $(ARGUMENTS)

# The crates of this workspace are compiled with the faults, those below as for every other build. ARGUMENTS="--filter feet" takes some.
PLANTED = RUSTC_WORKSPACE_WRAPPER=$(CURDIR)/scripts/planted/rustc.sh $(CARGO) run -p ipopt-contact-scenes --bin planted --

planted: install
	$(PLANTED) $(ARGUMENTS)

planted-quick: install
	$(PLANTED) --quick

package: install
	@./scripts/package.sh

msrv: install
	@./scripts/msrv.sh

bindings: install
	@./scripts/bindings.sh

# The dev profile again, for its checks for overflow.
fuzz-readers:
	$(CARGO) run -p contact-fem --example fuzz_readers -- $(SECONDS) $(SEED)

# Half of the time with default options, half with random ones. The arguments "case random 7" show case 7 of these again.
fuzz-binding: install
	$(CARGO) run -p contact-core --features ipopt --example fuzz_binding -- $(SECONDS) $(SEED)

# A case has a number, which the program takes as its third argument to show it again.
fuzz-scenes: install
	$(FUZZ_SCENES) $(SECONDS) $(SEED)

# ARGUMENTS="--count 660 --seed 7 --kinds cylinders,neutral" takes some.
random-scenes: install
	@command -v python3 >/dev/null || { echo "python3 is missing"; exit 1; }
	$(CARGO) build --release -p ipopt-contact --bin ipopt-contact
	scripts/random/run.py "$(or $(CARGO_TARGET_DIR),target)/release/ipopt-contact" $(ARGUMENTS)
