# The commands of the project. `make` alone lists them.

.PHONY: help demo test python hashes long fuzz mutants power-cut bench bench-plain atlases gallery pictures experiments guide keys window window-times notices bundle advisories clean
.DEFAULT_GOAL := help

help: ## list these commands
	@sed -n 's/^\([a-z-]*\):.*## /  make \1\t/p' $(MAKEFILE_LIST) | expand -t 21

demo: ## set up what is missing, build, open the window (or render to out/ where there is no display)
	@.ci/setup demo
	cargo build --release
	@if [ -n "$$DISPLAY$$WAYLAND_DISPLAY" ]; then \
		cargo run --release --quiet -- lab; status=$$?; \
		[ $$status -eq 1 ] || exit $$status; \
		echo "No window: rendering the torus to out/."; \
	else \
		echo "No display: rendering the torus to out/."; \
	fi; \
	cargo run --release --quiet -- render torus --preset cells --steps 400 \
		--out out/torus.png --out out/torus.mp4 --report out/torus.json

# By default a display resets when its last window closes, and refuses the next one meanwhile.
DISPLAY_OF_TESTS := -screen 0 1280x1024x24 -noreset

# Some of the tests: make test ONLY="walk diffuse"
ONLY ?=

test: ## set up what is missing, and run every test with Vulkan's validation layers on
	@.ci/setup test
	@.ci/test $(ONLY)

python: ## build the Python package into target/python, and run its tests (minutes)
	@.ci/setup test
	@.ci/python

hashes: ## write the states that `myxo selftest` expects to assets/hashes.tsv; a change of them goes into CHANGELOG.md
	@.ci/setup demo
	cargo build --release
	$(MYXO) selftest --engine cpu --table hashes.part
	mv hashes.part assets/hashes.tsv

long: fuzz ## run the long proofs: fuzz targets, built-in scenes by every strategy, and statistics (tables go to benches/results/), runs that are killed (an hour)
	@.ci/setup test
	MYXO_CHECK=1 cargo test --release --test command_line -- --ignored --nocapture --test-threads=1
	MYXO_CHECK=1 MYXO_TABLE=$(CURDIR)/benches/results/strategies.md MYXO_JONES_TABLE=$(CURDIR)/benches/results/jones.md \
		cargo test --release --test simulation -- --ignored --nocapture

# Seconds for each target.
FUZZ_SECONDS ?= 60

fuzz: ## look for files that break a reader: OBJ, glTF, PLY, STL, scenes, checkpoints, maps (a minute each); finds go to tests/fuzz/corpus
	@.ci/setup demo
	@.ci/fuzz $(FUZZ_SECONDS)

mutants: ## break a constant of every shader in turn and list the tests that turn red (an hour)
	@.ci/setup test
	.ci/mutants

power-cut: ## cut the power of disks while files are written, as root; none may be lost (minutes)
	@.ci/setup demo
	.ci/power-cut

MYXO := cargo run --release --quiet --
# Three times from the beginning, each past the steps in which particles are not yet in the order of the atlas.
MEASURE := $(MYXO) profile --steps 100 --warmup 34 --repeat 3
# Two scenes in turn.
AGAINST := $(MYXO) profile --steps 40 --warmup 34 --repeat 2
BALLS := benches/scenes

bench-plain: ## time the reference scenes without a look, to compare with other programs; reports go to benches/results/ (a minute or two)
	@.ci/setup demo
	cargo build --release
	@for scene in cube torus; do \
		$(MEASURE) benches/scenes/plain_$$scene.toml --report benches/results/plain_$$scene.json || exit 1; \
	done

bench: bench-plain ## time every kernel on the reference scenes, and how times grow; the figures go to benches/results/ (minutes)
	@mkdir -p benches/results/objects
	@for scene in cube torus; do \
		$(MEASURE) $$scene --report benches/results/$$scene.json || exit 1; \
	done
	$(MEASURE) torus --set physarum.sensing=walk --report benches/results/torus-walk.json
	$(MEASURE) torus --set particles.count=1000000 --report benches/results/torus-1m.json
	$(MEASURE) torus --set particles.count=1000000 --set physarum.sensing=walk --report benches/results/torus-walk-1m.json
	$(MYXO) profile crowd --steps 10 --warmup 4 --report benches/results/crowd.json
	$(MYXO) profile benches/scenes/tori.toml --steps 40 --warmup 34 --report benches/results/objects/tori.json
	$(MYXO) profile benches/scenes/tori.toml --steps 1 --warmup 0 --repeat 5 --report benches/results/objects/tori-cold.json
	$(AGAINST) trio --set transfer.strategy=none --against transfer.strategy=parallel --report benches/results/objects/trio-parallel.json
	$(MYXO) profile trio --steps 40 --warmup 240 --repeat 2 --set transfer.strategy=none --against transfer.strategy=parallel \
		--report benches/results/objects/trio-parallel-later.json
	@for balls in apart touching pushed; do \
		$(AGAINST) $(BALLS)/one_ball.toml --against $(BALLS)/balls_$$balls.toml --report benches/results/objects/balls-$$balls.json || exit 1; \
	done
	$(MYXO) bench particles texture edges objects transfer distance mesh --quick --out benches/results/scaling
	cargo run --release --example choices -- --out benches/results/scaling

# Every mesh that comes with the program.
MESHES := $(addprefix builtin:,cube torus icosphere plane capsule suzanne trefoil gyroid) assets/hand_animated.glb

atlases: ## lay every mesh out and write the table to benches/results/atlases.md
	@.ci/setup demo
	cargo build --release
	cargo run --release --quiet -- atlas --fresh --method charts $(MESHES) > atlases.part
	mv atlases.part benches/results/atlases.md

gallery: ## draw the small pictures of the lab's gallery, and all presets on one sheet (minutes)
	@.ci/setup demo
	cargo run --release --example gallery -- assets/thumbnails
	mv assets/thumbnails/presets.png assets/pictures/presets.png

pictures: ## draw the pictures and films of docs/gallery.md, by the commands in it (half an hour)
	@.ci/setup demo
	cargo build --release
	@grep '^myxo ' docs/gallery.md | PATH="$(CURDIR)/target/release:$$PATH" sh -ex

experiments: ## redo the experiments of docs/experiments.md, by the commands in it, draw its figures and compare its numbers (ten minutes)
	@.ci/setup demo
	cargo build --release
	@rm -rf target/experiments && mkdir -p target/experiments assets/experiments
	@grep -E '^(myxo|cp) ' docs/experiments.md | PATH="$(CURDIR)/target/release:$$PATH" sh -ex
	@.ci/experiments

guide: ## draw the strips of pictures in docs/guide.md, as docs/guide.toml says (half an hour)
	@.ci/setup demo
	cargo run --release --example guide -- docs/guide.toml assets/guide

keys: ## write the list of the window's keys into README.md and docs/guide.md
	@.ci/setup demo
	MYXO_WRITE_KEYS=1 cargo test --release --bin myxo documents_list_the_keys

window: ## take the picture of the window in docs/guide.md
	@.ci/setup test
	cargo build --release
	xvfb-run -a -s "-screen 0 1280x800x24 -noreset" .ci/window assets/guide/window.png

window-times: ## time the window: its start, keys, a large picture and a film; the tables go to the terminal (minutes)
	@.ci/setup test
	xvfb-run -a -s "$(DISPLAY_OF_TESTS)" \
		cargo test --release --test window window_times -- --ignored --nocapture

notices: ## write the licences of all that a binary contains to target/notices/ (needs cargo-about; minutes)
	@.ci/notices

bundle: ## pack program and tests into one archive in target/bundle/, for a machine with a card but no toolchain (minutes)
	@.ci/setup test
	@.ci/bundle

advisories: ## look for dependencies with known faults and for unmaintained ones (needs cargo-deny and the network)
	@command -v cargo-deny >/dev/null || \
		{ echo "advisories: cargo-deny is missing: install it by  cargo install --locked cargo-deny" >&2; exit 1; }
	cargo deny --locked --config .ci/deny.toml check advisories
	cargo deny --locked --config .ci/deny.toml --manifest-path tests/fuzz/Cargo.toml check advisories

clean: ## remove what was built (target/ and .shaderc/, not your pictures)
	cargo clean
	rm -rf .shaderc
