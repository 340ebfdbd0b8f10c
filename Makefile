# `make help` lists the targets. An active environment, or the one given as VENV=, is used instead of making .venv.
VENV ?= $(or $(VIRTUAL_ENV),$(CONDA_PREFIX),.venv)
PYTHON ?= python3
BIN := $(VENV)/bin
SENTENCE := "a busy downtown crossroads with a bus, cyclists and pedestrians, trees along the road"
# One stamp a checkout: an environment that another checkout has been installed into since is installed into again.
STAMP := $(VENV)/.lidardraft-$(firstword $(shell echo "$(CURDIR)" | cksum))
CORE := $(STAMP)-core
RUST := $(shell find rust -name '*.rs' 2>/dev/null) Cargo.toml Cargo.lock rust/python/Cargo.toml

.DEFAULT_GOAL := help
.PHONY: help demo demo-generate test check docs bench compare report-streets report-detail report-simulate report-generate report-clouds report-inputs report-outputs report-two-sample install weights

help: ## list the targets
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/^([a-z-]+):.*## /\1\t/' | expand -t 16

demo: $(if $(wildcard $(STAMP)),$(STAMP),$(CORE)) ## a sentence becomes labelled LiDAR scans, a picture and a page, in out/demo/
	$(BIN)/lidardraft simulate --text $(SENTENCE) --sensor os1-128 --seed 14 -n 4 --overwrite -o out/demo
	$(BIN)/lidardraft view out/demo/000000.bin -o out/demo/scan.html
	@echo 'The diffusion model needs torch: make demo-generate, or pip install ".[generate]" and'
	@echo '  lidardraft generate --text $(SENTENCE) --weights paper-small -o out/generated'

demo-generate: install ## a sentence becomes a simulated and a generated scan beside each other, in out/demo-generate/
	$(BIN)/python examples/demo.py

test: install ## all tests, Python and Rust
	$(BIN)/python -m pytest -n auto --dist worksteal
	PYO3_PYTHON="$(abspath $(BIN)/python)" cargo test --workspace --quiet

check: install ## formatters, linters, types, and the extension's types against its stub
	cargo fmt --all --check
	PYO3_PYTHON="$(abspath $(BIN)/python)" cargo clippy --workspace --all-targets --quiet -- -D warnings
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/python -m mypy.stubtest lidardraft._core --ignore-missing-stub
	@$(BIN)/python .ci/english

docs: install ## the site of the documentation, in docs/_build/html
	@"$(BIN)/python" -c 'import furo, myst_parser, sphinxarg' 2>/dev/null || { echo "make docs needs Python 3.11 and Sphinx: pip install -c constraints.txt '.[docs]'" >&2; exit 1; }
	"$(BIN)/python" -m sphinx -q -W --keep-going -b html docs docs/_build/html

bench: install ## rays per second of the caster
	cargo bench

compare: install ## the caster beside Open3D and Embree, in one table
	@"$(BIN)/python" -m pip show -q open3d embreex 2>/dev/null || \
	  "$(BIN)/python" -m pip install --disable-pip-version-check -c constraints.txt -e '.[bench]'
	"$(BIN)/python" benches/compare.py

report-streets: install ## how lifelike streets are, beside the recordings in the folder LIDARDRAFT_DATA
	"$(BIN)/python" benches/report_streets.py

report-detail: install ## how well detailed layouts obey the coarse ones, and how near both are to recordings
	"$(BIN)/python" benches/report_detail.py

report-simulate: install ## layouts of recordings: cast, cast + sensor model, simulated, beside the recordings
	"$(BIN)/python" benches/report_simulate.py

report-generate: install ## generated scans of unseen streets and of recordings, speed, goals
	"$(BIN)/python" benches/report_generate.py

report-two-sample: install ## how well a classifier tells streets from recordings, by what it looks at
	"$(BIN)/python" benches/report_two_sample.py

report-clouds: install ## how near the layouts of recordings come to them, and how long they take
	"$(BIN)/python" benches/report_cloud.py

report-outputs: install ## sequences, edits; exports in foreign readers; data sets killed twenty times
	"$(BIN)/python" benches/report_outputs.py
	"$(BIN)/python" benches/pictures.py formats -o out/formats.png
	"$(BIN)/python" -m pytest -q -m "" tests/formats/test_exports.py tests/cli/test_cli_dataset.py

report-inputs: install ## how well sentences, scripts, pictures, clouds and sketches become layouts, and bad files end
	"$(BIN)/python" benches/report_inputs.py

weights: install ## train paper-small on streets, in out/: hours
	$(BIN)/lidardraft-train street --recipe paper-small --work out/paper-small -o out/paper-small.safetensors

install: $(STAMP)

define environment
@cargo --version >/dev/null 2>&1 || { echo "lidardraft needs a Rust toolchain (cargo, 1.89 or newer): see rustup.rs" >&2; exit 1; }
	@cargo --version | awk '{ split($$2, v, "."); exit v[1] == 1 && v[2] < 89 }' || { echo "lidardraft needs Rust 1.89 or newer; this is $$(cargo --version)" >&2; exit 1; }
	@test -x "$(BIN)/python" || command -v $(PYTHON) >/dev/null || { echo "lidardraft needs Python 3.10 or newer: $(PYTHON) not found" >&2; exit 1; }
	@test -x "$(BIN)/python" && p="$(BIN)/python" || p=$(PYTHON); "$$p" -c 'import sys; v = sys.version_info; sys.exit(f"lidardraft needs Python 3.10 or newer; this is {v[0]}.{v[1]}: say make PYTHON=python3.x" if v < (3, 10) else 0)'
	@test -x "$(BIN)/python" || $(PYTHON) -m venv "$(VENV)" || { rm -rf "$(VENV)"; echo "$(PYTHON) cannot make environments: install its venv package" >&2; exit 1; }
	@"$(BIN)/python" -m pip --version >/dev/null || { echo "$(VENV) has no pip: remove it, or give another environment as VENV=" >&2; exit 1; }
endef

$(STAMP): pyproject.toml constraints.txt $(RUST)
	$(environment)
	"$(BIN)/python" -m pip install --disable-pip-version-check -c constraints.txt -e '.[dev]'
	@rm -f "$(VENV)"/.lidardraft-*
	@touch "$@"

$(CORE): pyproject.toml constraints.txt $(RUST)
	$(environment)
	"$(BIN)/python" -m pip install --disable-pip-version-check -c constraints.txt -e .
	@rm -f "$(VENV)"/.lidardraft-*
	@touch "$@"
