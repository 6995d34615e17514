# What there is to do; how is in scripts/. What pip, cargo and apt-get say goes to target/setup-*.log.
# PYTHON=python3.12 chooses the Python of .venv; by default it is the first of python3.13 … python3.11, python3 that will do.
export PYTHON
.DEFAULT_GOAL := help
.PHONY: help doctor build dev demo test docs alive bench bench-io fuzz study paper wheel lock clean

help: ## this list
	@sed -n 's/^\([a-z-]*\):[^#]*## /\1 /p' Makefile | while read -r name what; do printf 'make %-9s%s\n' "$$name" "$$what"; done

doctor: ## what this machine lacks for all of these; root on Debian or Ubuntu gets it installed
	@scripts/doctor.sh test --report

build: ## .venv with the package and its optimised extension: .venv/bin/sigmatau
	@scripts/doctor.sh build
	@scripts/venv.sh runtime
	@scripts/build.sh

dev: build ## the same with what the tests need: .venv/bin/python -m pytest
	@scripts/venv.sh dev

demo: build ## simulate a static log, analyse it, write demo/
	@.venv/bin/sigmatau demo

test: ## all checks and tests, as CI runs them; or some: make test STEPS="clippy python"
	@scripts/doctor.sh test
	@scripts/test.sh $(STEPS)

docs: build ## the site of the documentation: target/docs/html/index.html
	@scripts/venv.sh docs
	@.venv/bin/python docs/website/build.py

alive: ## the theory page that runs the numerics as WebAssembly: target/alive/index.html
	@scripts/alive.sh

bench: build ## speed, against other packages and the machine: docs/performance.md; ROUNDS=9, BILLION=1 pushes 10⁹ samples
	@scripts/venv.sh bench
	@.venv/bin/python -m benches.run $(if $(ROUNDS),--rounds $(ROUNDS)) $(if $(BILLION),--billion) $(if $(PARTS),--only $(PARTS))

bench-io: build ## a long log in each format, read whole, cut off and damaged: docs/formats.md
	@scripts/venv.sh dev
	@.venv/bin/python -m benches.formats $(if $(ROUNDS),--rounds $(ROUNDS))

fuzz: build ## mutated files to every parser, SECONDS=60 to each compiled one
	@scripts/venv.sh dev
	@scripts/fuzz.sh $(or $(SECONDS),60)

study: build ## Monte Carlo of the statistics, and seeded bugs: docs/study
	@scripts/venv.sh dev
	@.venv/bin/python -m studies.run
	@.venv/bin/python -m studies.mutations

paper: build ## the paper, reproduced: figures, tables and outputs of docs/paper
	@scripts/venv.sh dev
	@.venv/bin/python -m studies.paper
	@.venv/bin/python tests/docs/pages.py --write docs/paper/*.md

wheel: build ## dist/: source distribution and manylinux wheels, checked, and tried in empty environments; TARGETS="TRIPLE…"
	@scripts/venv.sh release
	@scripts/wheel.sh $(TARGETS)

lock: ## newest versions into requirements/
	@scripts/lock.sh

clean: ## remove all that was made here
	rm -rf .venv target dist demo .bench .study python/sigmatau/_core*.so
	rm -rf .mypy_cache .ruff_cache .pytest_cache .hypothesis .import_linter_cache
	find python tests benches studies -name __pycache__ -prune -exec rm -rf {} +
