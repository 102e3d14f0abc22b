# `make demo` and `make test` are all a fresh machine needs; the environment is made on the way.

# Another Python than the one found: make demo PYTHON=/path/to/python3.11
PYTHON ?=
PHOTOS ?=
OUT ?=
OPTIONS ?=
DATA ?=
ZIPS ?=
BLENDER ?=
SCENES ?=
DOCUMENTS ?=

VENV := .venv/bin/python

.PHONY: help demo rectify batch test coverage test-batch test-slow benchmark lint docs extension extension-repository \
	test-extension test-blender clean environment test-environment batch-environment batch-test-environment \
	docs-environment

help:
	@echo "make demo                        rectify the example photos"
	@echo "make rectify PHOTOS=dir OUT=dir  rectify your own"
	@echo "                                 OPTIONS='--paper A4' (all: $(VENV) headless/rectify.py --help)"
	@echo "make batch DOCUMENTS=dir OUT=dir rectify many documents: a folder of folders of photos, or a table"
	@echo "                                 OPTIONS='--config paper=A4 dpi=300' (docs/batch.md)"
	@echo "make test                        run the tests, without those that take long"
	@echo "make coverage                    the same, and print which share of the lines they run"
	@echo "make test-slow                   run those that take long: whole runs, and statistics over many cases"
	@echo "make test-batch                  run a batch of three small documents, one of them broken"
	@echo "make benchmark DATA=dir          measure on photo sets whose flat original is known"
	@echo "make lint                        check style and types"
	@echo "make docs                        write the manual's tables, and build it: out/docs/index.html"
	@echo "make extension                   build the Blender extension, a zip for each platform and Python, into dist/"
	@echo "                                 ZIPS='linux-x64-py313' builds these alone"
	@echo "make extension-repository        the same, and the index that makes dist/ an extension repository"
	@echo "make test-extension              build the zip for this machine, install it into a throw-away Blender, test it"
	@echo "make test-blender BLENDER=...    drive the add-on in a real Blender's window on a virtual screen, with pictures;"
	@echo "                                 CONTRIBUTING.md says which Blender"
	@echo "make clean                       remove the environment, the demo's results, the wheels and the zips"

environment:
	@PYTHON="$(PYTHON)" sh .ci/environment.sh

test-environment:
	@PYTHON="$(PYTHON)" sh .ci/environment.sh .ci/requirements-test.txt benchmarks/requirements.txt

batch-environment: environment
	@VENV=.venv-batch PYTHON="$(PYTHON)" sh .ci/environment.sh .ci/requirements-batch.txt .ci/requirements-text.txt

docs-environment:
	@PYTHON="$(PYTHON)" sh .ci/environment.sh .ci/requirements-docs.txt

demo: environment
	@$(VENV) headless/rectify.py examples/trifold_letter -o out/demo --paper Letter --resume
	@echo "page:   out/demo/page.tif"
	@echo "report: out/demo/report.json"

rectify:
	@test -n "$(PHOTOS)" || { echo "Say which photos: make rectify PHOTOS=folder OUT=folder" >&2; exit 2; }
	@test -n "$(OUT)" || { echo "Say where to: make rectify PHOTOS=folder OUT=folder" >&2; exit 2; }
	@$(MAKE) --no-print-directory environment
	@$(VENV) headless/rectify.py "$(PHOTOS)" -o "$(OUT)" $(OPTIONS)

batch-test-environment: environment
	@VENV=.venv-batch PYTHON="$(PYTHON)" sh .ci/environment.sh .ci/requirements-batch.txt .ci/requirements-text.txt .ci/requirements-schemas.txt

batch:
	@test -n "$(DOCUMENTS)" || { echo "Say which documents: make batch DOCUMENTS=folder OUT=folder" >&2; exit 2; }
	@test -n "$(OUT)" || { echo "Say where to: make batch DOCUMENTS=folder OUT=folder" >&2; exit 2; }
	@$(MAKE) --no-print-directory batch-environment
	@.venv-batch/bin/python workflow/batch.py "$(DOCUMENTS)" "$(OUT)" $(OPTIONS)

test: test-environment
	@$(VENV) -m pytest -n 2 --dist loadfile

# Lines that only run in the child processes of jobs and of pycolmap do not count.
coverage: test-environment
	@$(VENV) -m pytest -n 2 --dist loadfile --cov=core --cov=origami_addon --cov=headless --cov-report=term

test-batch: test-environment batch-test-environment
	@$(VENV) -m pytest -m batch tests/workflow

test-slow: test-environment
	@$(VENV) -m pytest -n 2 --dist loadfile -m 'slow and not download and not batch'

benchmark: test-environment
	@$(VENV) benchmarks/run.py $(if $(DATA),"$(DATA)") $(if $(OUT),-o "$(OUT)")

lint: test-environment
	@$(VENV) -m ruff check .
	@$(VENV) -m mypy -p origami.core -p origami.origami_addon -p origami.headless -p origami.workflow.delivery

docs: docs-environment
	@rm -rf out/docs
	@$(VENV) docs/tables.py
	@$(VENV) -m sphinx -q -W --keep-going -d .venv/doctrees docs out/docs
	@echo "out/docs/index.html"

extension: docs
	@$(VENV) .ci/extension.py $(ZIPS)

extension-repository: docs
	@$(VENV) .ci/extension.py --repository $(ZIPS)

test-extension: test-environment docs
	@$(VENV) -m pytest -m download tests/package

test-blender: test-environment docs
	@test -n "$(BLENDER)" || { echo "Say which Blender: make test-blender BLENDER=command-or-folder" >&2; exit 2; }
	@$(VENV) tests/blender/run.py "$(BLENDER)" $(if $(SCENES),--only $(SCENES))

clean:
	rm -rf .venv .venv-batch out dist wheels .mypy_cache .ruff_cache .pytest_cache
